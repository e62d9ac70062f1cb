"""Exit statuses of ``bpc`` and of its nodes, besides 0."""

DEFECT = 1  # a defect of bpc, or a check that found a fault
REFUSED = 2  # the command cannot be done as given
NOT_GOOD = 3  # a print that was judged has a defect
NOT_ENOUGH_SEEN = 4  # too little of a print is seen to judge it
INTERRUPTED = 130  # by one of the ending signals; shells use it for Ctrl-C
