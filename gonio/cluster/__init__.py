"""Work that outgrows one process: tasks known by their content, done here or on a Dask cluster.

    from gonio.cluster import Here, Run, RunFolder, connect
    run = Run(connect("tcp://host:8786", print), RunFolder("albedos.run"))
    for task, done in run.results(tasks): ...

A task is a function of gonio's and its inputs. The digest of both, of gonio's code and of the libraries
that compute is its key, under which its result is kept: what is done is never done again, and it does not
matter who did it. `gonio.cluster.sweep`, `pictures`, `checks` and `fits` cut work into tasks and join the
results.
"""

from gonio.cluster.codec import NotPortableError
from gonio.cluster.dask import ClusterError, connect
from gonio.cluster.engine import Engine, Here
from gonio.cluster.folder import RunFolder
from gonio.cluster.run import Run
from gonio.cluster.task import Done, Failure, Task

__all__ = [
    "ClusterError",
    "Done",
    "Engine",
    "Failure",
    "Here",
    "NotPortableError",
    "Run",
    "RunFolder",
    "Task",
    "connect",
]
