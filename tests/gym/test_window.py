"""Images of the whole scene: as arrays, and in a window where there is a screen."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest

from rlbench_pin.gym.environment import GymnasiumEnv, Window, WindowMissing

SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")


@pytest.fixture
def no_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine without a screen."""
    for name in SCREENS:
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def made_up_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    """A screen in memory."""
    pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


def test_rgb_array_shows_the_scene(no_screen: None) -> None:
    """`render` returns 640 x 360 pixels that change when the arm moves."""
    with GymnasiumEnv("reach_target", render_mode="rgb_array") as env:
        env.reset(seed=0)
        before = env.render()
        for _ in range(4):
            env.step(np.append(np.full(7, 0.1), 0.04))
        after = env.render()
    assert before is not None and after is not None
    assert before.shape == (360, 640, 3) and before.dtype == np.uint8
    assert before.std() > 10.0 and (before != after).mean() > 0.01


def test_without_a_mode_render_warns() -> None:
    """Rendering without a mode returns nothing and says what to pass."""
    with GymnasiumEnv("reach_target") as env, pytest.warns(UserWarning, match="render_mode='rgb_array'"):
        env.reset(seed=0)
        assert env.render() is None


def test_human_needs_a_screen(no_screen: None) -> None:
    """Without a screen the error says so, and what to use instead; the mode is not offered then."""
    with pytest.raises(WindowMissing, match="DISPLAY.*rgb_array"):
        gymnasium.make("rlbench_pin:rlbench_pin/reach_target-state-v0", render_mode="human")
    with GymnasiumEnv("reach_target") as env:
        assert env.metadata["render_modes"] == ["rgb_array"]


@pytest.mark.simulation
def test_human_needs_pygame(made_up_screen: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without pygame the error says how to get it."""
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(WindowMissing, match=r"pip install -e '\.\[human\]'"):
        Window("a title")


def test_a_screen_that_does_not_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """A display that is named but not there is a typed error too."""
    pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "nonesuch")
    with pytest.raises(WindowMissing, match="does not respond"):
        Window("a title").show(np.zeros((4, 4, 3), dtype=np.uint8))


@pytest.mark.simulation
def test_human_shows_every_step(made_up_screen: None) -> None:
    """With a screen the window shows the same image as `rgb_array`, after reset and after each step."""
    pygame = pytest.importorskip("pygame")
    action = np.append(np.full(7, 0.1), 0.04)
    with GymnasiumEnv("reach_target", render_mode="rgb_array") as env:
        env.reset(seed=0)
        pictures = [env.render(), *(env.render() for _ in range(2) if env.step(action))]
    with GymnasiumEnv("reach_target", render_mode="human") as env:
        assert env.metadata["render_modes"] == ["rgb_array", "human"]
        env.reset(seed=0)
        for picture in pictures:
            shown = pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)
            np.testing.assert_array_equal(shown, picture)
            env.step(action)
    assert pygame.display.get_surface() is None
    env.close()
