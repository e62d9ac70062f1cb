"""Write recordings, read them whole or torn, and measure them without a graph."""
