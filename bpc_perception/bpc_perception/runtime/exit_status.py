"""Exit statuses of ``bpc`` and of its nodes, besides 0."""

DEFECT = 1  # a defect of bpc, or a check that found a fault
REFUSED = 2  # the command cannot be done as given
INTERRUPTED = 130  # by one of the ending signals; shells use it for Ctrl-C
