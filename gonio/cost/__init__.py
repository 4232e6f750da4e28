"""What shaders cost on GPUs, measured on their machine code; no GPU is needed.

from gonio import cost
table = cost.cost({"eon": gonio.model("eon")}, gpus=cost.chosen(["navi21"]))
print(table.text())
"""

from gonio.cost.gpus import GPUS, CostError, Gpu, chosen
from gonio.cost.measured import Measured
from gonio.cost.table import cost, measure

__all__ = ["GPUS", "CostError", "Gpu", "Measured", "chosen", "cost", "measure"]
