"""A client of Trunnion, the service for programs, kinematics and calibration of five-axis machines.

    from trunnion import Trunnion

    machine = Trunnion("http://127.0.0.1:8080", key).machine("dmu-80")
    machine.compensate("part.nc", tool_radius_mm=5).save()

`trunnion.contract` has the types of every document.
"""

from . import connection
from .calibration import Calibration, CalibrationTrend, Covariance, LocationErrors
from .client import Trunnion
from .figure import Figure
from .files import Content
from .job import Event, Job
from .kinematics import Candidates, Joints, Poses
from .machine import Machine
from .problem import DigestMismatch, Fault, JobCancelled, Problem, TrunnionError, Unreachable, WaitTimeout
from .results import (
    Compensation,
    OnePass,
    Posting,
    ProgramSimulation,
    Result,
    Verification,
    WearCompensation,
)
from .servo import Servo, Simulation, Sweep
from .stored import Stored
from .tool import Tool, WearTrend

__version__ = connection.VERSION

__all__ = [
    "Calibration",
    "CalibrationTrend",
    "Candidates",
    "Compensation",
    "Content",
    "Covariance",
    "DigestMismatch",
    "Event",
    "Fault",
    "Figure",
    "Job",
    "JobCancelled",
    "Joints",
    "LocationErrors",
    "Machine",
    "OnePass",
    "Poses",
    "Posting",
    "Problem",
    "ProgramSimulation",
    "Result",
    "Servo",
    "Simulation",
    "Stored",
    "Sweep",
    "Tool",
    "Trunnion",
    "TrunnionError",
    "Unreachable",
    "Verification",
    "WaitTimeout",
    "WearCompensation",
    "WearTrend",
    "__version__",
]
