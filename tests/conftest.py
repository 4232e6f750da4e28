"""What all tests share. gonio comes first: it points Dr.Jit at a usable LLVM."""

import gonio  # noqa: F401
