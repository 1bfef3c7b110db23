"""The other way to write a PID controller: each sample changes the last output.

    u ← u + k_p Δe + k_i e dt - k_d Δ(dy/dt)          then cut to the limits

It is the position form whose integral is set to u - P - D after each sample: what a limit cuts off
is never remembered.

Source: K. J. Åström, R. M. Murray, Feedback Systems, 2nd edition, Princeton 2021, section 11.5
(velocity form). The swerve robot of Yogyakarta State University, 2024, names its speed controller
incremental, but adds the whole output of a position form to the speed each time.
"""

from __future__ import annotations

from math import inf

from robocon_course.tracking.pid import Pid, PidGains, PidLimits, PidState


class IncrementalPid(Pid):
    """A PID controller in incremental (velocity) form: each sample changes the last output.

        u ← u + k_p Δe + k_i e dt - k_d Δ(dy/dt)

    Between the limits it gives what `Pid` gives, to rounding. At a limit it forgets what does not
    fit, so it cannot wind up; and it can take over from any output without a jump. It needs k_i:
    without it nothing leads back what a limit once cut off.

    Parameters
    ----------
    gains : PidGains
    limits : PidLimits
        Without ``integral``, which this form does not keep.
    wrap : bool
        As in `Pid`.

    Raises
    ------
    ValueError
        Gains that are no finite numbers, or limits that leave nothing or name an integral.

    Examples
    --------
    >>> pid = IncrementalPid(PidGains(1.0, 0.5), PidLimits(low=0.0, high=1.0))
    >>> pid.take_over(0.5, error=0.25)
    >>> pid.update(2.0, 1.75, 0.5)
    0.5625
    """

    __slots__ = ()

    def __init__(
        self,
        gains: PidGains,
        limits: PidLimits = PidLimits(),  # noqa: B008 - a NamedTuple cannot change
        *,
        wrap: bool = False,
    ) -> None:
        super().__init__(gains, limits, wrap=wrap)
        if self._cap != inf:
            raise ValueError(
                f"limits.integral: the incremental form keeps no integral; leave it at infinity, "
                f"got {self._cap:g}"
            )

    def update(self, setpoint: float, measured: float, dt: float) -> float:
        """The output after one more sample.

        Parameters
        ----------
        setpoint, measured : float
            In the same unit. Where one is not finite, the last output holds.
        dt : float  [s]

        Returns
        -------
        float

        Raises
        ------
        ValueError
            dt is not positive.
        """
        output = super().update(setpoint, measured, dt)
        # With integral := u - P - D the next P + I + D is u + ΔP + k_i e dt + ΔD.
        self._integral = output - self._proportional - self._derivative
        return output

    def take_over(self, output: float, error: float = 0.0) -> None:
        """Go on from an output that somebody else gave, without a jump.

        Parameters
        ----------
        output : float
            The actuator's present command.
        error : float
            Setpoint minus measurement now.
        """
        proportional = self._k_p * error
        self.state = PidState(proportional, output - proportional, output=output)
