"""The panels of the page: each makes its elements once, and then shows what is new."""
