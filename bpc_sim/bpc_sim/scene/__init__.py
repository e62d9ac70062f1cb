"""What a synthetic camera sees: surfaces, light, lens, sensor."""
