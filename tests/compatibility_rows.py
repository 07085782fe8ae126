"""Which tests show what the rows of `docs/compatibility.md` say, in the order of the page."""

from __future__ import annotations

MODES, SPACES = "environment/actions/test_action_modes.py", "environment/actions/test_action_spaces.py"
TASKS, NATIVE = "environment/test_task_environment.py", "environment/test_differences.py"
KNOWN, OBJECTS, ROBOTS = (f"compat/test_differences{part}.py" for part in ("", "_objects", "_robots"))
KNOWN_TASKS = "compat/test_differences_tasks.py"

ROWS: dict[str, str] = {
    # Wider than usual
    "Seeds as arguments": f"{TASKS}::test_demo_i_starts_from_seed_plus_i {TASKS}::test_the_same_seed_gives_the_same_start",
    "Same seed, same bytes": "sim/test_build_again.py::test_what_follows_does_not_depend_on_the_past "
    "integration/test_reproducible.py::test_a_demo_has_the_same_bytes_in_another_process "
    "compat/test_environment.py::test_the_global_generator_decides",
    "Context manager": f"{KNOWN}::test_leaving_the_block_shuts_down "
    f"{TASKS}::test_launching_twice_is_refused_and_shutdown_allows_a_new_launch",
    "Going back": f"{TASKS}::test_states_can_be_taken_up_again",
    "Choosing tasks": f"{NATIVE}::test_a_task_is_a_class_or_a_name",
    "Case of `robot_setup`": f"{TASKS}::test_unknown_robots_and_missing_datasets_are_refused "
    "compat/test_environment.py::test_errors_of_construction",
    "Variation -1": f"{TASKS}::test_variations_are_checked compat/test_environment.py::test_variations",
    "Snapshots in demos": f"{TASKS}::test_demos_carry_all_that_is_needed_to_play_them_again "
    "compat/test_environment.py::test_live_demos_and_back",
    "Action modes are settings": "environment/actions/test_mode.py::test_one_mode_in_two_environments_is_as_two_modes "
    "environment/actions/test_mode.py::test_modes_that_know_their_shape_and_act_are_enough",
    "Hooks of action modes": "environment/actions/test_hooks.py::test_sharing_a_tick_is_the_joint_position_action_mode "
    "environment/actions/test_hooks.py::test_the_step_of_a_motion_is_the_whole_motion "
    "compat/test_action_modes_of_users.py::test_hooks_of_a_derived_mode_are_called",
    "Shape and bounds of actions": f"{TASKS}::test_action_size_needs_a_launch {MODES}::test_every_mode_states_bounds "
    "compat/test_action_modes.py::test_shapes_and_bounds",
    "Frames by word": f"{NATIVE}::test_delta_angles_and_words_for_frames "
    "compat/test_action_modes.py::test_the_frame_of_the_end_effector",
    "Relative velocities and torques": f"{SPACES}::test_a_velocity_delta_adds_to_the_measured_velocity "
    f"{SPACES}::test_torque_differences_add_to_the_torques_of_the_last_action",
    "`datasets.key_frames(demo)`": "datasets/test_key_frames.py::test_a_live_demonstration",
    "Names of tasks in commands": "cli/test_list_tasks.py::test_commas_are_as_good_as_spaces "
    "cli/test_known_names.py::test_the_flags_of_upstream_mean_what_they_mean_there cli/test_record.py::test_record_and_resume",
    "The generator of data sets": "compat/test_data.py::test_generator_refusals compat/test_data.py::test_the_generator_goes_on",
    "Point clouds alone": "environment/observations/test_config.py::test_a_point_cloud_alone_is_delivered",
    "Events of randomization": "environment/randomization/test_randomizer.py::test_events_are_distinct "
    f"{KNOWN}::test_randomization_of_programs",
    "White lists of randomization": "environment/randomization/test_randomizer.py::test_white_and_black_lists_work "
    "compat/test_environment_looks.py::test_white_lists_and_other_names",
    "Dynamics randomization": "environment/randomization/test_randomizer.py::test_dynamics_change_motion_and_stay_within_bounds "
    "compat/test_environment_looks.py::test_dynamics_change",
    "`get_scene_data()`": "environment/observations/test_placing.py::test_before_the_first_task_and_in_scene_data "
    "compat/test_environment.py::test_scene_data",
    "`ColorCondition`": f"{KNOWN_TASKS}::test_colours_can_be_asked_for",
    # Programs and import names
    "Scenes of one's own tasks": "compat/test_tasks_paper.py::test_a_task_without_a_scene_says_where_it_looked",
    "Classes typed in a notebook": f"{KNOWN}::test_a_typed_class_has_no_scene",
    "Models, scenes and scripts of other simulators": "compat/test_objects.py::test_the_fixed_scene "
    "compat/test_objects_sensors.py::test_the_simulator_starts_steps_and_ends",
    "`pyrep.backend.sim`": f"{KNOWN}::test_no_c_functions",
    "Other modules of `pyrep`": f"{KNOWN}::test_other_modules_of_pyrep_are_missing",
    "Tasks that the library does not have yet": "compat/test_tasks_names.py::test_a_task_that_the_library_lacks_says_so",
    "`rlbench.TASKS`, `TASKS_PATH`": "compat/test_tasks_names.py::test_tasks_path_lists_the_library "
    f"{KNOWN}::test_versions_and_lists",
    "`TTT_FILE`": f"{KNOWN}::test_the_base_scene_is_a_name",
    "`__version__`": f"{KNOWN}::test_versions_and_lists",
    "Action modes of the first releases": "compat/test_install.py::test_programs_of_the_first_releases_are_told_what_changed",
    "Several environments in one process": "compat/test_environment_several.py::test_they_take_turns",
    "Packages that RLBench brings along": "compat/test_programs.py::test_packages_that_come_along_with_rlbench",
    # Environment
    "Import names, natively": "test_front_door.py::test_a_door_opens test_front_door.py::test_parts_are_imported_by_themselves",
    "Tools of RLBench's repository": "cli/test_new.py::test_a_new_task_passes_check_and_can_be_drawn "
    "cli/test_video_and_doctor.py::test_video_writes_a_film_that_moves",
    "`Scene`": f"{NATIVE}::test_there_is_a_runtime_and_no_scene",
    "`register_step_callback`": "environment/test_step_callbacks.py::"
    "test_a_callback_is_called_once_a_tick_however_often_it_is_registered "
    "environment/test_step_callbacks.py::test_removing_all_leaves_randomization",
    "Native randomness": f"{NATIVE}::test_no_global_generator_is_read_or_set",
    "Known randomness": f"{KNOWN}::test_an_episode_takes_one_number_of_the_global_generator "
    "compat/test_environment.py::test_the_global_generator_decides",
    "`reset_to_demo` and the global generator": f"{KNOWN}::test_reset_to_demo_sets_no_generator",
    "Default observation config": f"{KNOWN}::test_default_configs_are_not_shared "
    "environment/observations/test_config.py::test_every_config_gets_fresh_cameras",
    "`set_variation` below -1": f"{TASKS}::test_variations_are_checked compat/test_environment.py::test_variations",
    "`shaped_rewards=True`, but the task has none": f"{TASKS}::test_shaped_rewards_are_the_tasks_own "
    "compat/test_environment.py::test_shaped_rewards",
    "`step` before `reset`": f"{TASKS}::test_step_before_reset_is_refused compat/test_environment.py::test_the_loop",
    "`robot_setup`": f"{KNOWN}::test_other_arms_are_refused_at_launch "
    f"{TASKS}::test_unknown_robots_and_missing_datasets_are_refused",
    "`attach_grasped_objects`": f"{NATIVE}::test_grasping_is_left_to_the_environment "
    f"{KNOWN}::test_grasping_is_left_to_the_environment",
    "`headless`": f"{KNOWN}::test_no_window_opens",
    "Default textures and lights of randomization": f"{NATIVE}::test_lights_change_by_default",
    "`VisualRandomizationConfig.sample(n)`": f"{KNOWN}::test_randomization_of_programs "
    "environment/randomization/test_randomizer.py::test_textures_are_drawn_with_or_without_a_generator",
    "Scene and objects": f"{NATIVE}::test_scenes_are_toml_and_objects_urdf",
    # Actions
    "Speed of planned motions": f"{NATIVE}::test_planned_motions_keep_their_speed_along_the_path "
    "planning/test_timing.py::test_torque_limits_are_kept_everywhere "
    "compat/test_robots_paths.py::test_the_pace_of_the_arm_is_the_pace_of_its_paths",
    "Jerk of planned motions": "planning/test_timing.py::test_acceleration_can_be_eased "
    "compat/test_robots_paths.py::test_the_pace_of_the_arm_is_the_pace_of_its_paths",
    "Planning is not drawn anew": f"{NATIVE}::test_all_plans_of_an_episode_draw_the_same_numbers "
    f"{KNOWN}::test_a_motion_is_planned_alike_again",
    "Ninth value, natively": "environment/test_key_frames.py::test_it_counts_instead_of_the_setting "
    "environment/test_key_frames.py::test_a_refused_plan_is_made_without_checks_when_asked",
    "Ninth value, known names": f"{KNOWN}::test_poses_by_planning_take_a_fallback_only_from_the_ninth_value "
    "compat/test_action_modes.py::test_a_ninth_value_says_whether_collisions_are_ignored",
    "`JointTorque`": f"{SPACES}::test_torque_beyond_gravity_accelerates_in_its_direction "
    f"{SPACES}::test_after_a_torque_action_the_arm_brakes_and_reports_what_acted "
    f"{KNOWN}::test_joint_torque_has_its_own_sign_and_stops",
    "Speeds beyond the joints' limits": f"{NATIVE}::test_the_arm_keeps_the_speed_limits_of_its_joints "
    f"{KNOWN}::test_the_arm_keeps_the_speed_limits_of_its_joints",
    "NaN and infinity": f"{NATIVE}::test_a_refused_hand_stops_the_arm_as_well "
    "compat/test_action_modes.py::test_a_refused_action_changes_nothing",
    "Refused actions": f"{NATIVE}::test_a_refused_hand_stops_the_arm_as_well "
    "compat/test_action_modes.py::test_a_refused_action_changes_nothing",
    "`Discrete` outside 0 to 1": f"{NATIVE}::test_a_refused_hand_stops_the_arm_as_well",
    "Closing the hand": f"{ROBOTS}::test_the_hand_takes_what_stops_its_fingers",
    "Ticks of the hand": f"{NATIVE}::test_ticks_of_the_hand_are_steps_of_the_runtime "
    f"{KNOWN}::test_ticks_of_the_hand_are_steps_of_the_scene",
    "`GripperJointPosition`": f"{ROBOTS}::test_finger_positions_take_it_as_well {KNOWN}::test_differences_of_fingers_are_added "
    f"{SPACES}::test_finger_positions_hold_what_stops_them",
    "`ERJointViaIK(delta_angle=True)` in absolute mode": f"{NATIVE}::test_delta_angles_and_words_for_frames "
    f"{KNOWN}::test_delta_angles_need_relative_mode",
    "Tip frame": f"{NATIVE}::test_the_tip_at_the_known_start_joints {KNOWN}::test_the_tip_at_the_known_start_joints",
    # Observations and demonstrations
    "`joint_forces`": f"{NATIVE}::test_forces_do_not_depend_on_the_direction_of_motion "
    f"{KNOWN_TASKS}::test_forces_do_not_depend_on_the_direction_of_motion",
    "Masks": "sim/render/test_renderer.py::test_ids_are_integers_of_the_table_and_stable "
    "environment/observations/test_seeing.py::test_ids_stay_over_twenty_resets",
    "Cameras that deliver masks alone": f"{NATIVE}::test_a_camera_may_deliver_masks_alone",
    "`misc['mask_names']`": "environment/observations/test_misc.py::test_names_of_masks_come_with_masks_only",
    "`misc['joint_poses']`": f"{NATIVE}::test_joint_poses_are_without_noise "
    "environment/observations/test_misc.py::test_joint_poses_are_those_of_the_simulated_links "
    "environment/observations/test_misc.py::test_recorded_demonstrations_keep_what_misc_said",
    "`misc['descriptions']`": "environment/observations/test_misc.py::test_descriptions_are_the_instructions_of_the_episode "
    "environment/observations/test_misc.py::test_episode_files_hold_descriptions_once_and_bring_them_back",
    "`misc['joint_position_action']`": f"{NATIVE}::test_actions_of_frames_do_not_stay_behind "
    "compat/test_environment.py::test_live_demos_and_back",
    "`wrist_camera_matrix`": f"{NATIVE}::test_a_camera_matrix_is_in_misc {KNOWN_TASKS}::test_a_camera_matrix_is_in_misc",
    "`rgb_handles_to_mask`": "environment/observations/test_masks.py::test_whole_numbers_are_bytes "
    "environment/observations/test_masks.py::test_floats_are_parts_of_one",
    "Noise": "environment/observations/test_config.py::test_noise_is_seeded_and_changes_no_argument "
    f"{KNOWN_TASKS}::test_noise_leaves_its_argument "
    "compat/test_environment_looks.py::test_noise_of_programs_and_of_the_package",
    "Noise models, natively": "environment/observations/test_config.py::test_noise_is_seeded_and_changes_no_argument",
    "`CameraConfig`, natively": f"{NATIVE}::test_settings_of_a_camera_go_by_name",
    "Frames of demonstrations": f"{NATIVE}::test_every_frame_has_a_tick_of_its_own "
    f"{KNOWN_TASKS}::test_the_first_frame_is_the_start",
    "`ignore_collisions` of frames": "environment/test_key_frames.py::test_every_frame_says_how_its_leg_was_planned "
    f"{KNOWN_TASKS}::test_a_flag_for_collisions_can_be_left_out",
    "`Demo.random_seed`": f"{TASKS}::test_a_demo_with_the_state_of_a_generator_starts_from_its_snapshot "
    f"{TASKS}::test_a_demo_without_a_usable_seed_is_refused",
    "`Demo.restore_state()`": "test_observation.py::test_restoring_the_state_seeds_the_global_generator "
    "test_observation.py::test_restoring_a_full_state_repeats_the_draws_after_it "
    "compat/test_environment.py::test_live_demos_and_back",
    # Tasks and conditions
    "Empty list of success conditions": "tasks/test_task.py::test_an_empty_success_list_is_a_mistake",
    "Sentences of an episode": "tasks/test_task.py::test_instructions_are_a_list_of_different_sentences "
    f"{KNOWN_TASKS}::test_a_task_begins_when_it_is_loaded",
    "When `init_task` runs": f"{KNOWN_TASKS}::test_a_task_begins_when_it_is_loaded",
    "Draws of a task's own code": f"{KNOWN_TASKS}::test_a_task_begins_when_it_is_loaded "
    "compat/test_tasks_paper.py::test_what_a_task_draws_repeats_with_the_seed",
    "Random placement of the task": "tasks/test_task.py::test_the_defaults_come_from_the_scene_file",
    "Default low-dimensional state": "tasks/test_task.py::test_the_default_low_dim_state_is_poses_then_joints_by_name "
    f"{KNOWN_TASKS}::test_the_default_state_holds_bodies_and_joints",
    "Made shapes in the low-dimensional state": f"{KNOWN_TASKS}::test_shapes_made_later_are_not_in_the_default_state "
    "compat/test_tasks_made_objects.py::test_what_init_task_makes_is_part_of_the_state",
    "Things that a library task keeps in attributes": "compat/test_environment_changed.py"
    "::test_library_tasks_show_what_they_keep",
    "Replaced parts": "compat/test_environment_changed.py::test_a_replaced_sample_is_asked_for_the_base "
    "compat/test_environment_changed.py::test_pose_actions_go_where_a_replaced_get_path_leads "
    "compat/test_environment_changed.py::test_the_arm_starts_where_the_scene_says",
    "How long made shapes and colours last": "compat/test_objects_shapes.py::test_how_long_shapes_stay "
    f"{KNOWN_TASKS}::test_switches_and_masses_stay",
    "`Scene.init_episode(place_demo=True)`": f"{KNOWN_TASKS}::test_placing_a_demo_has_no_effect",
    "Mass, friction and switches": f"{KNOWN_TASKS}::test_switches_and_masses_stay",
    "`FollowCondition`": f"{KNOWN_TASKS}::test_points_are_visited_within_half_of_the_limit",
    "`sample_procedural_objects`": f"{KNOWN_TASKS}::test_procedural_objects_are_solids_of_this_package",
    "Frames of waypoints": f"{KNOWN_TASKS}::test_waypoints_stay",
    "Task files, natively": "tasks/test_library.py::test_an_episode_depends_on_its_generator_alone",
    "Partly open hands": f"{KNOWN_TASKS}::test_a_waypoint_that_closes_a_little_says_so",
    "Hands that arrive turned": f"{KNOWN}::test_the_hand_may_arrive_turned",
    "Start functions of waypoints": "environment/test_looking_ahead.py::test_a_reset_looks_at_every_round",
    # pyrep objects
    "Handles": "compat/test_objects.py::test_handles_are_the_numbers_in_masks",
    "Parents that physics moves": f"{OBJECTS}::test_parents_that_physics_moves",
    "What hangs on the arm": f"{OBJECTS}::test_bodies_do_not_hang_on_the_arm compat/test_objects.py::test_set_parent",
    "Meshes": f"{OBJECTS}::test_meshes_are_solid_as_their_hulls",
    "Transparency": f"{OBJECTS}::test_half_transparent_things_are_drawn_opaque",
    "Planes": f"{OBJECTS}::test_planes_are_not_drawn compat/test_objects.py::test_regions_are_planes_and_sensors_sensors",
    "Textures": f"{OBJECTS}::test_textures_have_one_mapping",
    "Joining and scaling": f"{OBJECTS}::test_what_cannot_be_is_refused",
    "Forces on shapes": "compat/test_objects_shapes.py::test_forces_push_and_turn",
    "Names of links and joints": "compat/test_objects_sensors.py::test_joints_of_objects",
    "`remove`": "compat/test_objects.py::test_the_fixed_scene "
    "compat/test_objects.py::test_names_can_be_changed_and_removed_things_are_gone",
    "`copy`": f"{OBJECTS}::test_what_cannot_be_is_refused compat/test_objects_shapes.py::test_copies",
    "`set_dynamic` of bodies with joints": f"{OBJECTS}::test_bodies_with_joints_stay_as_loaded "
    "compat/test_objects_shapes.py::test_static_and_dynamic",
    "Models": f"{OBJECTS}::test_everything_with_children_is_a_model",
    "Joints of objects": f"{OBJECTS}::test_joints_of_objects_have_no_force "
    "compat/test_objects_sensors.py::test_joints_of_objects",
    "`set_joint_interval`": "compat/test_objects_sensors.py::test_joints_of_objects",
    "Joint modes": f"{OBJECTS}::test_joints_of_objects_have_no_force {OBJECTS}::test_what_cannot_be_is_refused",
    "`ForceSensor`": f"{OBJECTS}::test_force_sensors_are_named_after_what_is_pressed",
    "`ProximitySensor`": "compat/test_objects_sensors.py::test_proximity_sensors",
    "`Light`, `Camera`, `Octree`": "compat/test_objects_sensors.py::test_the_simulator_starts_steps_and_ends "
    f"{OBJECTS}::test_what_cannot_be_is_refused",
    "Vision sensors": f"{OBJECTS}::test_pictures_show_the_present_instant {OBJECTS}::test_what_cannot_be_is_refused "
    "compat/test_objects_cameras.py::test_settings_of_a_camera compat/test_objects_cameras.py::test_the_cameras_of_observations",
    "Options of `CartesianPath.create`": f"{OBJECTS}::test_orientations_of_paths_are_those_of_the_points",
    "`PyRep.step`": f"{OBJECTS}::test_a_stopped_simulation_stays_as_it_is "
    "compat/test_objects_sensors.py::test_the_simulator_starts_steps_and_ends",
    "`PyRep.stop`": f"{OBJECTS}::test_a_stopped_simulation_stays_as_it_is",
    # Robots
    "Other arms": "compat/test_robots.py::test_a_second_arm_and_arms_that_are_missing_are_refused",
    "A second robot": "compat/test_robots.py::test_a_second_arm_and_arms_that_are_missing_are_refused "
    "compat/test_robots_gripper.py::test_a_second_hand_is_refused",
    "`get_jacobian`": "compat/test_robots.py::test_the_jacobian_has_a_row_per_joint",
    "Inverse kinematics": "compat/test_robots.py::test_settings_of_inverse_kinematics",
    "Arguments of planning": f"{ROBOTS}::test_arguments_of_planning_have_no_effect",
    "Planning algorithms": f"{ROBOTS}::test_six_names_of_algorithms_are_searches",
    "Joint intervals": f"{ROBOTS}::test_joint_intervals_cannot_be_set",
    "`set_joint_positions`": f"{ROBOTS}::test_positions_are_put_without_physics_either_way",
    "Motors at zero velocity": f"{ROBOTS}::test_motors_at_zero_velocity_always_hold",
    "Force caps": "compat/test_robots.py::test_capped_forces_with_velocities_out_of_reach_are_torques",
    "Fingers": f"{ROBOTS}::test_fingers_get_the_mean",
    "Grasping": f"{ROBOTS}::test_links_cannot_be_grasped "
    "compat/test_robots_gripper.py::test_grasp_takes_what_is_between_the_fingers_only",
    "`check_arm_collision`": f"{ROBOTS}::test_the_arm_collides_with_itself_too",
    "Drawing paths": f"{ROBOTS}::test_arguments_of_planning_have_no_effect",
    # Data
    "Stored demos": "datasets/test_dataset.py::test_layout "
    "datasets/formats/test_rlbench_pickle.py::test_a_hostile_pickle_runs_nothing "
    "datasets/formats/test_rlbench_folders.py::test_what_is_read_is_what_was_written compat/test_data.py::test_layout_on_disk",
    "`image_paths=True`": "environment/test_stored.py::test_paths_of_pictures "
    "compat/test_data.py::test_stored_demos_without_a_simulator",
    "Pictures of another size than stored": "environment/test_stored.py::test_pictures_are_scaled_with_their_intrinsics",
    "Demos with made shapes": f"{KNOWN_TASKS}::test_made_shapes_come_back_where_their_files_are",
    "Demos pickled by a program": f"{KNOWN_TASKS}::test_a_pickled_demo_names_our_classes",
    "Generating into a used folder": "compat/test_data.py::test_generator_refusals "
    "compat/test_data.py::test_the_generator_goes_on",
    # Gymnasium
    "`rlbench-generate-dataset`": f"{KNOWN}::test_the_generator_is_no_command",
    "Native ids": "gym/test_ids.py::test_every_task_has_both_ids "
    "gym/test_environment.py::test_the_seed_is_that_of_the_task_environment",
    "Refused actions in gymnasium": "gym/test_refusals.py::test_a_refused_pose_is_reported_and_changes_nothing "
    f"{KNOWN_TASKS}::test_the_same_seed_gives_the_same_episode_in_gymnasium",
    "Quaternions in gymnasium": "gym/test_refusals.py::test_quaternions_are_brought_to_unit_length",
    "Length of episodes": "gym/test_environment.py::test_a_time_limit_truncates gym/test_ids.py::test_every_task_has_both_ids",
    "`info`": f"{KNOWN_TASKS}::test_the_same_seed_gives_the_same_episode_in_gymnasium "
    "gym/test_spaces.py::test_observations_carry_what_the_interface_promises",
    "`options['reset_to_demo']`": "gym/test_environment.py::test_reset_to_demo_starts_as_the_demo_and_its_actions_succeed "
    "compat/test_environment_gym.py::test_reset_to_demo",
    "Synchronous vector environments": "gym/test_vector.py::test_four_in_one_process_are_as_four_alone "
    "compat/test_environment_gym.py::test_vector_environments",
    "Nondeterministic flag": f"{KNOWN_TASKS}::test_the_same_seed_gives_the_same_episode_in_gymnasium",
    "`render_mode='human'`": "gym/test_window.py::test_human_needs_a_screen gym/test_window.py::test_human_needs_pygame "
    f"{KNOWN_TASKS}::test_a_window_needs_a_screen",
}
"""Topic of a row -> the tests that show it, with spaces between them; below `tests/`."""
