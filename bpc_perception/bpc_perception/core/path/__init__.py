"""The path of a print: where and when the nozzle passed, and what the extruder did."""
