"""From a file to an outline: pictures, drawings, solids and lists of points become one clean polygon."""
