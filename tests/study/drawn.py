"""What matplotlib axes show, as plain values."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrow, Polygon

from deformpush.record.palette import Colour


def rgb(colour) -> Colour:
    """A matplotlib colour in whole numbers."""
    r, g, b = (round(255 * channel) for channel in to_rgb(colour))
    return r, g, b


def curves(axis: Axes) -> list[Line2D]:
    """Lines through points, without levels and single dots."""
    return [line for line in axis.lines if len(line.get_xdata()) > 1 and not is_level(line)]


def is_level(line: Line2D) -> bool:
    """Whether it is a horizontal line from edge to edge."""
    return line.get_transform() == line.axes.get_yaxis_transform(which="grid")


def levels(axis: Axes) -> list[tuple[float, Colour]]:
    """Heights and colours of the horizontal lines."""
    return [(float(line.get_ydata()[0]), rgb(line.get_color())) for line in axis.lines if is_level(line)]


def dots(axis: Axes) -> list[Line2D]:
    """Single points."""
    return [line for line in axis.lines if len(line.get_xdata()) == 1]


def data(line: Line2D) -> np.ndarray:
    """The points `(n, 2)` of a line."""
    return np.column_stack([line.get_xdata(), line.get_ydata()]).astype(float)


def outlines(axis: Axes) -> list[tuple[Colour, np.ndarray]]:
    """Colours and vertices of the polygons that are not filled."""
    return [(rgb(one.get_edgecolor()), vertices(one)) for one in _polygons(axis) if not _is_filled(one)]


def fills(axis: Axes) -> list[tuple[Colour, np.ndarray]]:
    """Colours and vertices of the filled polygons."""
    return [(rgb(one.get_facecolor()), vertices(one)) for one in _polygons(axis) if _is_filled(one)]


def vertices(polygon: Polygon) -> np.ndarray:
    """Its corners `(n, 2)`, the first one not repeated."""
    return np.asarray(polygon.get_xy())[:-1]


def arrows(axis: Axes) -> list[FancyArrow]:
    """The arrows."""
    return [patch for patch in axis.patches if isinstance(patch, FancyArrow)]


def spans(axis: Axes) -> list[tuple[float, float]]:
    """First and last k of the shaded pushes, which `axvspan` draws from bottom to top."""
    tall = axis.get_xaxis_transform(which="grid")
    shaded = [patch for patch in axis.patches if patch.get_data_transform() == tall]
    return [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in shaded]


def bands(axis: Axes) -> list[tuple[Colour, np.ndarray, np.ndarray]]:
    """Colours, lower and upper edges of what is filled between two curves over k = 0, 1, ..."""
    found = []
    for one in axis.collections:
        corners = one.get_paths()[0].vertices
        k = np.arange(int(corners[:, 0].max()) + 1)
        edges = [corners[corners[:, 0] == at, 1] for at in k]
        low, high = np.array([[edge.min(), edge.max()] for edge in edges]).T
        found.append((rgb(one.get_facecolor()[0]), low, high))
    return found


def legend(figure_or_axis: Figure | Axes) -> dict[str, Colour]:
    """Texts of the legend and the colours of their lines."""
    found = figure_or_axis.legends[0] if isinstance(figure_or_axis, Figure) else figure_or_axis.get_legend()
    texts = [text.get_text() for text in found.get_texts()]
    return dict(zip(texts, [rgb(line.get_color()) for line in found.get_lines()], strict=True))


def words(axis: Axes) -> list[str]:
    """What is written inside the axes."""
    return [text.get_text() for text in axis.texts]


def _polygons(axis: Axes) -> list[Polygon]:
    return [p for p in axis.patches if isinstance(p, Polygon) and not isinstance(p, FancyArrow)]


def _is_filled(polygon: Polygon) -> bool:
    return polygon.get_facecolor()[3] > 0
