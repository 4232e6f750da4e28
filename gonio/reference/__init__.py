"""Ground truth for layered models: unbiased random walks through stacks of clear layers.

from gonio.reference import Layer, Stack
stack = Stack([Layer(eta=1.5, alpha=0.1, sigma_a=0.3)], base=gonio.EON(roughness=0.5))
f = stack.eval(wi, wo, walks=4096)            # f.value and its standard error f.error, (..., 3)
Stack.of(gonio.model("weidlich_wilkie"))      # the layers that an approximation stands for
"""

from gonio.reference.stack import Estimate, Layer, Stack, Walked

__all__ = ["Estimate", "Layer", "Stack", "Walked"]
