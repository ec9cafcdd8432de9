"""The report page: pictures, noise curves with the truth drawn in, tables, how to repeat it."""
