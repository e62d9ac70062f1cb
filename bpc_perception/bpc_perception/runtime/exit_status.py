"""Exit statuses of ``bpc`` and of its nodes, besides 0."""

DEFECT = 1  # of ours, or a check that found something amiss
REFUSED = 2  # what was asked for cannot be done as it was asked
INTERRUPTED = 130  # by one of the ending signals, as shells say it of Ctrl-C
