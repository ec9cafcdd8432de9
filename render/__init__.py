"""From the scene to the sensor plane: rate images in photo-electrons per second."""
