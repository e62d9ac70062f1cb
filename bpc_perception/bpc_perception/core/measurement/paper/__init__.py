"""The published method: Zobeidi et al., IROS 2026, Sec. III."""
