"""Robot, extruder, camera and controller of the synthetic printer, on the topics of real ones."""

# Imported before NumPy: it limits the threads of BLAS, as for the nodes of the product.
import bpc_perception.nodes  # noqa: F401
