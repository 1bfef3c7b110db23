"""Which settings for this robot and this path? Try some, keep the best, look around it.

A rule of thumb says where to begin: look ahead by what the robot rolls within its lag, and a little
more. How fast it may be in bends is left over from the time allowed. Trials say the rest.
"""

from __future__ import annotations

from itertools import product
from math import inf

from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray
from robocon_course.tracking.differential import DifferentialModel
from robocon_course.tracking.polyline import as_path
from robocon_course.tracking.trial import TrackingSettings, time_allowed, trial

_LAGS, _LEAST, _SHARES, _LATERAL = (0.5, 1.0), (0.02, 0.03, 0.05), (0.65, 0.85), (0.3, 0.8, 2.0)
_FACTORS = (1.3, 1.15, 1.07)


def tune(model: DifferentialModel, path: ArrayLike) -> TrackingSettings:
    """Settings with which a robot keeps closest to a path and is in time.

    Parameters
    ----------
    model : DifferentialModel
    path : array_like, shape (n, 2)  [m, map]

    Returns
    -------
    TrackingSettings
        The best of a hundred trials or so that took no longer than `time_allowed`. Where none did,
        those that were least late.

    Raises
    ------
    ValueError
        No path.

    Examples
    --------
    >>> model, path = DifferentialModel(), [[0.05 * k, 0.0] for k in range(61)]
    >>> run = trial(path, model, tune(model, path))
    >>> run.duration <= time_allowed(path, model)
    True
    """
    path, known = as_path(path), {}

    def cost(settings: TrackingSettings) -> tuple[float, float]:
        """How late, then how far off; remembered."""
        if settings not in known:
            known[settings] = _cost(path, model, settings)
        return known[settings]

    best = min(_begin(model), key=cost)
    for factor in _FACTORS:
        better = best
        while True:
            best = min([better, *_around(better, factor)], key=cost)
            if best == better:
                break
            better = best
    return best


def _cost(
    path: FloatArray, model: DifferentialModel, settings: TrackingSettings
) -> tuple[float, float]:
    run = trial(path, model, settings)
    late = max(0.0, run.duration - time_allowed(path, model))
    return (late, run.worst) if late < inf else (inf, inf)


def _begin(model: DifferentialModel) -> list[TrackingSettings]:
    """Settings worth a first try."""
    return [
        TrackingSettings(lags * model.lag, least, share * model.max_speed, lateral)
        for lags, least, share, lateral in product(_LAGS, _LEAST, _SHARES, _LATERAL)
    ]


def _around(settings: TrackingSettings, factor: float) -> list[TrackingSettings]:
    """The same with one setting a little larger or smaller."""
    return [
        settings._replace(**{name: value * change})
        for name, value in settings._asdict().items()
        for change in (factor, 1.0 / factor)
    ]
