"""The compiled part of the package, loaded when it is first needed."""
import atexit
import os
import weakref

_simulations = weakref.WeakSet()
_module = None


def load():
    """The compiled part."""
    global _module
    if _module is None:
        # What Open MPI needs to run anywhere: as root, in containers, and with more ranks than cores.
        for name, value in {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                            "OMPI_MCA_rmaps_base_oversubscribe": "1",
                            "OMPI_MCA_btl_vader_single_copy_mechanism": "none"}.items():
            os.environ.setdefault(name, value)
        from . import _grains
        _module = _grains
        atexit.register(_end)
    return _module


def address(comm):
    """The address of a communicator of mpi4py, or 0 for this process by itself or the ranks of its mpirun."""
    if comm is None:
        return 0
    from mpi4py import MPI
    return MPI._addressof(comm)


def keep(simulation):
    """Remembers a simulation that must be gone before MPI ends."""
    _simulations.add(simulation)


def _end():
    for simulation in list(_simulations):
        simulation._abandon()
    _module.finish()
