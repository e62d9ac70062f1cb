"""The ROS nodes: each converts, calls the core, converts and publishes."""

import os

# NumPy reads this when it is first loaded. Matrices here are 3 x 3, so threads for them only take
# cores from others.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
