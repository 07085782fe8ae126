"""Progress of an evaluation on stderr."""

from __future__ import annotations

from tqdm import tqdm

from rlbench_pin.evaluation.run import EvaluationProgress


class EvaluationBar:
    """Episodes done, their rate, and how many of them succeeded so far.

    Args:
        what: What is evaluated.
    """

    def __init__(self, what: str) -> None:
        self._bar: tqdm | None = None
        self._what = what

    def __call__(self, progress: EvaluationProgress) -> None:
        """Show how far it is."""
        if self._bar is None:
            total, found = progress.wanted, progress.found
            self._bar = tqdm(total=total, initial=found, unit="episode", desc=self._what, dynamic_ncols=True)
        played = progress.found + progress.done
        self._bar.update(played - self._bar.n)
        notes = [f"success {100.0 * progress.successes / played:.0f} %"] if played else []
        notes += [progress.latest.item.name] if progress.latest is not None else []
        notes += [f"{progress.faults} faults"] if progress.faults else []
        notes += [f"{progress.deaths} workers died"] if progress.deaths else []
        self._bar.set_postfix_str(", ".join(notes))

    def close(self) -> None:
        """Leave the line as it is."""
        if self._bar is not None:
            self._bar.close()
