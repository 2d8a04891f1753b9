"""Pictures as bytes."""

import numpy as np


def encode(image: np.ndarray, width: int, quality: int) -> bytes:
    """JPEG of an RGB image `(H, W, 3)`, scaled down to at most `width` pixels."""
    import cv2

    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    scale = width / bgr.shape[1]
    if scale < 1:
        bgr = cv2.resize(bgr, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    _, data = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])
    return data.tobytes()


def decode(data: np.ndarray) -> np.ndarray:
    """RGB image `(H, W, 3)` of the bytes `(n,)` uint8 of a picture."""
    import cv2

    return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR_RGB))
