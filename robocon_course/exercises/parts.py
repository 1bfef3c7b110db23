"""Mine, reference or mixed: the robot's parts with accepted answers in place."""

from __future__ import annotations

from robocon_course.autopilot import Parts
from robocon_course.exercises.workspace import Workspace, WorkspaceError


def robot_parts(which: str = "mixed", *, workspace: Workspace | None = None) -> Parts:
    """The robot's parts.

    Parameters
    ----------
    which : {"mixed", "mine", "reference"}
        ``"mixed"``: your accepted parts, the course's for the rest. ``"mine"``: only your own.
        ``"reference"``: only the course's.
    workspace : Workspace, optional
        Where the accepted parts lie; without it beside the notebook.

    Raises
    ------
    WorkspaceError
        ``"mine"`` was asked for and parts are missing; the message lists them.
    """
    if which not in ("mixed", "mine", "reference"):
        raise ValueError(f"which: expected 'mixed', 'mine' or 'reference', got {which!r}")
    workspace = workspace or Workspace()
    accepted = {exercise_id.partition(".")[2]: exercise_id for exercise_id in workspace.in_use()}
    missing = [name for name in Parts.names() if name not in accepted]
    if which == "mine" and missing:
        raise WorkspaceError(f"not accepted yet: {', '.join(missing)}; use 'mixed' until then")
    if which == "reference":
        return Parts()
    mine = {name: workspace.part(accepted[name]) for name in Parts.names() if name in accepted}
    return Parts(**mine, mine=tuple(mine))
