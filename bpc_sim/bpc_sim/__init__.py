"""A synthetic bioprinter with known truth: scene, camera, robot and extruder."""
