"""Tables and images show what the results say, whatever the names in them are."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rlbench_pin.errors import InvalidValue
from rlbench_pin.evaluation.results.comparison import compare
from rlbench_pin.evaluation.results.plots import COLORS, draw_results
from rlbench_pin.evaluation.results.records import Results
from rlbench_pin.evaluation.results.statistics import Summary, summarise
from rlbench_pin.evaluation.results.tables import comparison_table, overview_table, printable, task_table
from tests.evaluation.results.made import results

FIRST = results({"reach_target": "1111111100", "open_drawer": "0000000000"}, "first")
SECOND = results({"reach_target": "1111111111", "open_drawer": "1111111f11"}, "second")


def summary(made: Results) -> Summary:
    """Return what came of an evaluation."""
    return summarise(made, np.random.default_rng(0))


def test_a_table_has_a_row_per_task_and_one_for_the_mean() -> None:
    """With intervals, and sentences about what was refused and how little ten episodes tell."""
    text = task_table(summary(FIRST)).text()
    rows = [re.split(r"\s{2,}", line) for line in text.splitlines()]
    assert rows[0] == ["first"]
    assert rows[3] == ["reach_target", "10", "80 %", "49 to 94", "80 %", "14", "0.60", "0.20", "12", "45", "0"]
    assert rows[4][:5] == ["open_drawer", "10", "0 %", "0 to 28", "0 %"]
    assert rows[5][:3] == ["mean over tasks", "20", "40 %"]
    assert "Refused actions: collision 12, workspace 24." in text and "10 episodes of a task give wide intervals" in text
    assert "crashed 1" in task_table(summary(SECOND)).text()


def test_one_task_has_no_mean() -> None:
    """It would say the same again."""
    made = summary(results({"reach_target": "1" * 100}))
    assert "mean over tasks" not in task_table(made).text() + overview_table([made, made]).text()
    assert "give wide intervals" not in task_table(made).text()


def test_markdown() -> None:
    """The same cells between bars, with a rule below the head."""
    lines = overview_table([summary(FIRST), summary(SECOND)]).text(markdown=True).splitlines()
    assert lines[0].startswith("### Success")
    assert [cell.strip() for cell in lines[2].split("|")] == ["", "task", "first", "second", ""]
    assert set(lines[3]) == set("|-:") and len({line.count("|") for line in lines[2:]}) == 1
    assert [cell.strip() for cell in lines[4].split("|")][1:3] == ["reach_target", "80 % (49 to 94)"]


def test_a_comparison_says_who_is_better() -> None:
    """By task, and over all episodes, with what else differs."""
    text = comparison_table(compare(FIRST, SECOND, np.random.default_rng(0))).text()
    assert "second compared with first: success" in text
    assert re.search(r"^all +20 +8 +0 +11 +1 +\+55\.0 +0\.0010 +0\.0005$", text, re.MULTILINE)
    assert "significant at 5 %, 'second' is better" in text and "corrected for 2 tests: open_drawer differs." in text
    same = comparison_table(compare(FIRST, FIRST, np.random.default_rng(0))).text()
    assert "not significant" in same and "none differs" in same


def test_names_of_files_are_harmless() -> None:
    """No escape code reaches a terminal, no bar breaks a table, and no name fills the screen."""
    assert printable("a\x1b[31mb\n") == "a?[31mb?"
    assert printable("a|b", markdown=True) == r"a\|b"
    assert len(printable("x" * 1000)) == 60
    text = task_table(summary(results({"reach_target": "1"}, "\x1b]0;title\x07"))).text()
    assert "\x1b" not in text and "\x07" not in text


def test_a_png_has_the_colours_of_the_policies(tmp_path: Path) -> None:
    """And as many pixels as the tasks need; equal results draw equal bytes."""
    both = [summary(FIRST), summary(SECOND)]
    path = draw_results(tmp_path / "deep" / "a.png", both)
    again = draw_results(tmp_path / "b.PNG", both)
    assert path.read_bytes() == again.read_bytes()
    picture = np.asarray(Image.open(path).convert("RGB")).reshape(-1, 3)
    for color, wide in zip(COLORS, (True, True, False)):
        rgb = [int(color[i : i + 2], 16) for i in (1, 3, 5)]
        assert ((picture == rgb).all(1).sum() > 1000) == wide
    more = draw_results(tmp_path / "c.png", [summary(results({f"t{i}": "1" for i in range(20)}))])
    assert Image.open(more).height > Image.open(path).height


def test_an_svg_has_the_names_as_text(tmp_path: Path) -> None:
    """It is well formed, and equal for equal results."""
    path = draw_results(tmp_path / "a.svg", [summary(FIRST), summary(SECOND)])
    texts = "".join(ET.parse(path).getroot().itertext())
    for name in ("reach_target", "open_drawer", "mean over tasks", "first", "second", "10 episodes of each task"):
        assert name in texts
    assert path.read_bytes() == draw_results(tmp_path / "b.svg", [summary(FIRST), summary(SECOND)]).read_bytes()


def test_hostile_names_are_drawn(tmp_path: Path) -> None:
    """No formula is looked for, none is left out of the legend, and a long one is cut."""
    made = [summary(results({"$\\frac{": "10", "_b": "11"}, name)) for name in ("$x_{", "_hidden", "a" * 5000, "<&>\x1b")]
    texts = "".join(ET.parse(draw_results(tmp_path / "a.svg", made)).getroot().itertext())
    assert "_hidden" in texts and "$x_{" in texts and "a" * 60 not in texts and "<&>?" in texts


def test_what_cannot_be_drawn(tmp_path: Path) -> None:
    """Other endings, no policy, too many; nothing is written."""
    made = summary(FIRST)
    for name, several in (("a.pdf", [made]), ("a", [made]), ("a.png", []), ("a.png", [made] * 9)):
        with pytest.raises(InvalidValue):
            draw_results(tmp_path / name, several)
    assert list(tmp_path.iterdir()) == []
    empty = summary(Results("noop", {}, "x", ("reach_target",), (0,), {}, {}, "", ()))
    assert draw_results(tmp_path / "a.png", [empty]).exists()
    assert "reach_target" in task_table(empty).text()
