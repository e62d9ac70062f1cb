"""Many prints on control charts: from their summaries to groups, charts and tables."""
