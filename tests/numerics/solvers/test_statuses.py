"""Every word that a solver may stop with has one meaning; what no table knows has failed."""

import clarabel
import pytest

from synthesis.numerics.solvers import clarabel as cones
from synthesis.numerics.solvers import ipopt
from synthesis.numerics.solvers.statuses import StopReason

# Ipopt's ApplicationReturnStatus, IpReturnCodes_inc.h: those that leave no usable point have failed
FAILURES = (
    "User_Requested_Stop", "Restoration_Failed", "Error_In_Step_Computation",
    "Not_Enough_Degrees_Of_Freedom", "Invalid_Problem_Definition", "Invalid_Option",
    "Invalid_Number_Detected", "Unrecoverable_Exception", "NonIpopt_Exception_Thrown",
    "Insufficient_Memory", "Internal_Error",
)  # fmt: skip
MEANINGS = 20


def test_every_word_of_ipopt() -> None:
    assert len(ipopt.STATUSES) + len(FAILURES) == MEANINGS
    assert not set(ipopt.STATUSES) & set(FAILURES)


@pytest.mark.parametrize("word", [*FAILURES, "Something_New"])
def test_what_no_table_knows_has_failed(word: str) -> None:
    assert ipopt.stop_reason(word) is StopReason.FAILED


def test_every_word_of_clarabel() -> None:
    words = {word for word in dir(clarabel.SolverStatus) if word[0].isupper()}
    failures = {"NumericalError", "CallbackTerminated", "Unsolved"}
    assert words - failures == set(cones.STATUSES)
