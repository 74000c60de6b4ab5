"""Positions of the pixels of drawn maps."""

import numpy as np
from matplotlib.image import AxesImage


def find_pixel_centres(image: AxesImage) -> tuple[np.ndarray, np.ndarray]:
    """Return the x coordinates of the pixel columns and the y coordinates of the pixel rows of a drawn map."""
    left, right, bottom, top = image.get_extent()
    rows, columns = image.get_array().shape[:2]
    return tuple(
        start + (np.arange(count) + 0.5) * (stop - start) / count
        for start, stop, count in ((left, right, columns), (bottom, top, rows))
    )
