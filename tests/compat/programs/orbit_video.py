"""Records videos: a sensor that orbits the table while demonstrations and actions run, one image every other step."""

import os
import tempfile

import av
import numpy as np
from pyrep.const import RenderMode
from pyrep.objects.dummy import Dummy
from pyrep.objects.vision_sensor import VisionSensor

from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.environment import Environment
from rlbench.observation_config import ObservationConfig
from rlbench.tasks import TakeLidOffSaucepan


class CircleCamera:
    """Turns about the origin dummy, which the camera hangs on."""

    def __init__(self, camera, origin, speed):
        self.camera, self.origin, self.speed = camera, origin, speed
        camera.set_parent(origin, keep_in_place=True)

    def step(self):
        self.origin.rotate([0, 0, self.speed])


class Recorder:
    def __init__(self, motion, every=4):
        self.motion, self.every = motion, every
        self.steps, self.frames, self.places = 0, [], []

    def take_snap(self):
        self.steps += 1
        self.motion.step()
        if self.steps % self.every == 0:
            self.frames.append((self.motion.camera.capture_rgb() * 255.0).astype(np.uint8))
            self.places.append(self.motion.camera.get_position())

    def save(self, path):
        with av.open(path, "w") as container:
            stream = container.add_stream("mpeg4", rate=20)
            stream.height, stream.width = self.frames[0].shape[:2]
            stream.pix_fmt = "yuv420p"
            for frame in self.frames:
                container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="rgb24")))
            container.mux(stream.encode())


def main():
    np.random.seed(12)
    obs_config = ObservationConfig(record_gripper_closing=True)
    obs_config.set_all(False)
    env = Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=obs_config, headless=True)
    env.launch()
    task = env.get_task(TakeLidOffSaucepan)
    task.reset()

    camera = VisionSensor.create([160, 96], render_mode=RenderMode.OPENGL)
    camera.set_pose(Dummy("cam_cinematic_placeholder").get_pose())
    recorder = Recorder(CircleCamera(camera, Dummy("cam_cinematic_base"), 0.02))
    task._scene.register_step_callback(recorder.take_snap)
    demo = task.get_demos(1, live_demos=True)[0]
    in_demo = len(recorder.frames)
    for _ in range(8):
        task.step(np.array([0.0] * 7 + [0.0]))
    task._scene.register_step_callback(None)
    task.step(np.array([0.0] * 7 + [0.0]))

    assert in_demo * 4 >= len(demo) - 4, (in_demo, len(demo))
    assert len(recorder.frames) == in_demo + 2 or len(recorder.frames) > in_demo
    places = np.array(recorder.places)
    base = Dummy("cam_cinematic_base").get_position()
    radius = np.linalg.norm(places[:, :2] - base[:2], axis=1)
    assert radius.std() < 1e-3 and np.ptp(places[:, 2]) < 1e-3, "the camera leaves its circle"
    swept = 0.02 * 4 * (len(places) - 1)
    chord = np.linalg.norm(places[-1] - places[0])
    assert abs(chord - 2 * radius[0] * abs(np.sin(swept / 2))) < 0.02, (chord, swept)
    changes = [np.abs(a.astype(float) - b).mean() for a, b in zip(recorder.frames, recorder.frames[1:])]
    assert min(changes) > 0.2, "two images are the same"
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "orbit.mp4")
        recorder.save(path)
        with av.open(path) as container:
            stored = sum(1 for _ in container.decode(video=0))
    assert stored == len(recorder.frames)
    print("recorded %d frames of a demonstration of %d" % (stored, len(demo)))
    env.shutdown()


if __name__ == "__main__":
    main()
