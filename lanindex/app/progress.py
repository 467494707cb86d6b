"""How far a long job is, as a bar on standard error. Imports rich: import it late."""

from __future__ import annotations

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeRemainingColumn,
)
from rich.text import Text


class _Rate(ProgressColumn):
    """Things a second."""

    def render(self, task: Task) -> Text:
        """Return the rate as far as it is known."""
        rate = task.finished_speed or task.speed
        return Text(f"{rate:.3g}/s" if rate else "")


class Bar:
    """Things done of a number, with their rate and the time that is left."""

    def __init__(self, total: int, noun: str, *, colors: bool) -> None:
        self._total = total
        self._progress = Progress(
            BarColumn(bar_width=20),
            MofNCompleteColumn(),
            TextColumn(noun),
            _Rate(),
            TimeRemainingColumn(),
            console=Console(stderr=True, no_color=None if colors else True),
            transient=True,
            redirect_stdout=False,  # other lines step aside by themselves
            redirect_stderr=False,
        )
        self._task = self._progress.add_task(noun, total=total)

    def advance(self) -> None:
        """Count one more."""
        self._progress.advance(self._task)

    def reach(self, done: int) -> None:
        """Count so many in all; that it is done is drawn at once."""
        self._progress.update(self._task, completed=done, refresh=done >= self._total)

    def show(self) -> None:
        """Draw it."""
        self._progress.start()

    def hide(self) -> None:
        """Take it from the terminal; it may be shown again."""
        self._progress.stop()
