"""What all tests share: one thread for small matrices, as the command line takes it.

Threads of several workers would spin against each other; it has to be said before numpy is imported.
"""

import os


for _name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
