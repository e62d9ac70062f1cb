"""Robot, extruder, camera and controller of the synthetic printer, on the topics of real ones."""

# Before NumPy is loaded: it limits the threads of BLAS, as for the nodes of the product.
import bpc_perception.nodes  # noqa: F401
