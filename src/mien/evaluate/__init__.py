"""How right a result is: figures against a known truth, and the cases that have one."""

from mien.evaluate.cases import Case
from mien.evaluate.collection import all_cases, quick_cases
from mien.evaluate.embedded import embedded_cases
from mien.evaluate.suite import run_case, run_suite, summary

__all__ = ["Case", "all_cases", "embedded_cases", "quick_cases", "run_case", "run_suite", "summary"]
