"""A window for an ink: which settings give the width that is wanted, learnt from a sweep."""
