"""For the test suites of others: assertions about answers, and a conformance kit for backends."""

from .assertions import assert_backends_agree, assert_complementary, assert_encloses, assert_same_contact
from .conformance import check_backend
from .report import CheckResult, ConformanceReport

__all__ = [
    "CheckResult",
    "ConformanceReport",
    "assert_backends_agree",
    "assert_complementary",
    "assert_encloses",
    "assert_same_contact",
    "check_backend",
]
