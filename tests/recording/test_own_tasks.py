"""Tasks of one's own: recorded from their file, kept by the dataset, and run from there only when the user says so."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from rlbench_pin.assets import ASSETS
from rlbench_pin.cli.new import New
from rlbench_pin.datasets import episode_files, kept_task, verify_task
from rlbench_pin.environment.actions.modes import JointPositionActionMode
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.errors import DatasetConflict, EpisodeFileError, TaskError, UnknownName, UntrustedTaskFile
from rlbench_pin.recording import ImageConfig, ProcessEngine, RecordConfig, SerialEngine, read_recording, record, rerender
from rlbench_pin.recording.replay import replay_stored
from rlbench_pin.tasks import own_tasks, stored_task

pytestmark = pytest.mark.simulation
IMAGES = ImageConfig(products=())


@pytest.fixture(scope="module")
def mine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A task file of one's own."""
    folder = tmp_path_factory.mktemp("mine")
    New("touch_it", folder).run()
    return folder / "touch_it.py"


@pytest.fixture(scope="module")
def recorded(mine: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset of two episodes, recorded by two workers, and of one of the library."""
    root = tmp_path_factory.mktemp("recorded")
    config = RecordConfig(tasks=(str(mine),), episodes=2, variations=2, draw_variations=False, images=IMAGES)
    report = record(config, root, engine=ProcessEngine(2))
    assert (report.recorded, report.missing) == (2, 0)
    return root


@pytest.fixture
def dataset(recorded: Path, tmp_path: Path) -> Iterator[Path]:
    """A copy of it that a test may change, in another folder."""
    yield Path(shutil.copytree(recorded, tmp_path / "copy"))


def test_the_dataset_keeps_the_pair(mine: Path, recorded: Path) -> None:
    """Byte for byte; the settings name the task and no path."""
    kept = kept_task(recorded, "touch_it")
    assert kept is not None
    assert kept.contents() == {file.name: file.read_bytes() for file in (mine, mine.with_suffix(".toml"))}
    assert read_recording(recorded).tasks == ("touch_it",)
    verify_task(recorded, "touch_it", structure=True)


def test_the_episodes_do_not_depend_on_where_the_file_is_or_on_workers(mine: Path, recorded: Path, tmp_path: Path) -> None:
    """The same manifest from another folder, in one process."""
    moved = shutil.copytree(mine.parent, tmp_path / "moved")
    config = RecordConfig(tasks=(str(moved / mine.name),), episodes=2, variations=2, draw_variations=False, images=IMAGES)
    record(config, tmp_path / "again", engine=SerialEngine())
    manifests = [(root / "touch_it" / "manifest.json").read_bytes() for root in (recorded, tmp_path / "again")]
    assert manifests[0] == manifests[1]


def test_kept_code_runs_only_when_the_user_says_so(mine: Path, dataset: Path) -> None:
    """Replay, rerendering and resuming refuse it with the way to go on, and work when it is trusted or named."""
    with pytest.raises(UntrustedTaskFile, match="--trust-task-files") as caught:
        list(replay_stored([dataset]))
    assert caught.value.path == dataset / "touch_it" / "task_file" / "touch_it.py"
    for settings in ({"trust_task_files": True}, {"own": own_tasks([mine])}):
        assert [result.reached for result in replay_stored([dataset], **settings)] == [True, True]  # type: ignore[arg-type]
    (file,) = episode_files(dataset, "touch_it", 0)
    assert [result.reached for result in replay_stored([file], trust_task_files=True)] == [True]


def test_a_damaged_copy_is_not_run_even_when_trusted(dataset: Path) -> None:
    """What was recorded is not what lies there."""
    (dataset / "touch_it" / "task_file" / "touch_it.py").write_text("raise SystemExit('run')\n")
    with pytest.raises(EpisodeFileError, match="SHA-256 differs"):
        stored_task(dataset, "touch_it", trust_task_files=True)


def test_a_recording_is_resumed_from_its_copy(dataset: Path) -> None:
    """From another folder, when trusted; a lost episode comes out as it was."""
    (file,) = episode_files(dataset, "touch_it", 1)
    before = file.read_bytes()
    file.unlink()
    config = read_recording(dataset)
    with pytest.raises(UntrustedTaskFile):
        record(config, dataset, engine=SerialEngine(), resume=True)
    report = record(config, dataset, engine=SerialEngine(), resume=True, trust_task_files=True)
    assert (report.found, report.recorded) == (1, 1)
    assert file.read_bytes() == before


def test_a_path_in_the_settings_is_not_followed(mine: Path, dataset: Path) -> None:
    """Whoever wrote the settings does not choose which code runs here."""
    path = dataset / "recording.json"
    path.write_text(path.read_text().replace('"touch_it"', f'"{mine}"'))
    assert read_recording(dataset).tasks == ("touch_it",)
    path.write_text(path.read_text().replace(f'"{mine}"', '"../../x y.py"'))
    with pytest.raises(EpisodeFileError):
        read_recording(dataset)


def test_a_changed_file_does_not_go_on_with_the_old_episodes(mine: Path, dataset: Path, tmp_path: Path) -> None:
    """The changed files are named, and the settings of the folder stay as they were."""
    changed = shutil.copytree(mine.parent, tmp_path / "changed") / mine.name
    changed.write_text(changed.read_text() + "# changed\n")
    before = (dataset / "recording.json").read_bytes()
    config = RecordConfig(tasks=(str(changed),), episodes=3, variations=2, draw_variations=False, images=IMAGES)
    with pytest.raises(DatasetConflict, match=r"\['touch_it.py'\] differ"):
        record(config, dataset, engine=SerialEngine(), resume=True)
    assert (dataset / "recording.json").read_bytes() == before


def test_two_tasks_of_one_name_are_refused(mine: Path, tmp_path: Path) -> None:
    """One file twice is one task; two files of one name are none."""
    other = shutil.copytree(mine.parent, tmp_path / "other") / mine.name
    config = RecordConfig(tasks=(str(mine), str(other)), episodes=1, images=IMAGES)
    with pytest.raises(TaskError, match="Two different tasks have the name 'touch_it'"):
        record(config, tmp_path / "out", engine=SerialEngine())


def test_an_own_task_and_the_librarys_of_that_name_do_not_mix(tmp_path: Path) -> None:
    """In either order."""
    New("reach_target_x", tmp_path / "mine").run()
    for suffix in (".py", ".toml"):
        file = tmp_path / "mine" / f"reach_target_x{suffix}"
        file.write_text(file.read_text().replace("ReachTargetX", "ReachTarget"))
        file.rename(file.with_name(f"reach_target{suffix}"))
    own = RecordConfig(tasks=(str(tmp_path / "mine" / "reach_target.py"),), episodes=1, images=IMAGES)
    library = RecordConfig(tasks=("ReachTarget",), episodes=1, images=IMAGES)
    record(own, tmp_path / "own", engine=SerialEngine())
    with pytest.raises(UntrustedTaskFile, match="The installed task of that name"):
        record(library, tmp_path / "own", engine=SerialEngine(), resume=True)
    record(library, tmp_path / "library", engine=SerialEngine())
    with pytest.raises(DatasetConflict, match="the library task 'reach_target'"):
        record(own, tmp_path / "library", engine=SerialEngine(), resume=True)


def test_rerendering_takes_the_files_along(mine: Path, dataset: Path, tmp_path: Path) -> None:
    """By workers of their own, from the copy or from the file that is named."""
    images = ImageConfig(cameras=("front",), products=("rgb",), image_size=(16, 16))
    with pytest.raises(UntrustedTaskFile):
        rerender(dataset, tmp_path / "out", images)
    report = rerender(dataset, tmp_path / "out", images, engine=ProcessEngine(1), trust_task_files=True)
    assert (report.recorded, report.missing) == (2, 0)
    kept, before = kept_task(tmp_path / "out", "touch_it"), kept_task(dataset, "touch_it")
    assert kept is not None and before is not None and kept.files == before.files
    assert rerender(dataset, tmp_path / "out", images, engine=SerialEngine(), own=own_tasks([mine])).found == 2


def test_stored_demonstrations_are_read_without_any_code(dataset: Path) -> None:
    """By the name under which they are stored; a name that is not is answered as ever."""
    environment = Environment(JointPositionActionMode(), dataset_root=str(dataset), obs_config=low_dim_config())
    assert len(environment.get_demos("touch_it", 1, variation_number=1)) == 1
    assert "ball" in environment.get_task_descriptions_with_episode("touch_it", 0)[0]
    with pytest.raises(UnknownName):
        environment.get_demos("touch_them", 1)


def test_a_file_that_changes_while_it_is_recorded_costs_its_episodes(mine: Path, tmp_path: Path) -> None:
    """No dataset holds episodes of two versions."""
    copy = shutil.copytree(mine.parent, tmp_path / "mine") / mine.name
    config = RecordConfig(tasks=(str(copy),), episodes=1, variations=1, draw_variations=False, images=IMAGES)

    class ChangesTheFile(SerialEngine):
        def map(self, *arguments):  # type: ignore[no-untyped-def]
            copy.write_text(copy.read_text() + "# changed\n")
            return super().map(*arguments)

    report = record(config, tmp_path / "out", engine=ChangesTheFile())
    assert report.missing == 1
    assert "changed while it was recorded" in report.failed[0].failures[0]


def test_models_of_its_own_go_with_a_task(tmp_path: Path) -> None:
    """The copy in the dataset is complete: it replays where nothing else of the task is left."""
    folder = tmp_path / "mine"
    New("touch_it", folder).run()
    shutil.copytree(ASSETS / "objects" / "ball_marker", folder / "ball")
    scene = folder / "touch_it.toml"
    scene.write_text(scene.read_text().replace('"objects/ball_marker/ball_marker.urdf"', '"./ball/ball_marker.urdf"'))
    config = RecordConfig(tasks=(str(folder / "touch_it.py"),), episodes=1, images=IMAGES)
    record(config, tmp_path / "data", engine=SerialEngine())
    shutil.rmtree(folder)
    assert (tmp_path / "data" / "touch_it" / "task_file" / "ball" / "ball_marker.urdf").is_file()
    assert [result.reached for result in replay_stored([tmp_path / "data"], trust_task_files=True)] == [True]
