"""`gonio bench`: gonio's speed beside plain C++, the memory's and Mitsuba's own plug-ins.

from gonio.bench import bench
print(bench(rows=["eon"]).text())
"""

from gonio.bench.command import bench
from gonio.bench.report import BenchError, Report

__all__ = ["BenchError", "Report", "bench"]
