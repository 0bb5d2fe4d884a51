"""Light presets. shaders/lighting.glsl holds the studio's; others replace its constants when shaders are built.

The lights are constants in the shaders because on a software renderer that is faster than uniforms.
"""

from dataclasses import dataclass

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Lighting:
    """A set of lights: colours linear RGB; directions in image axes, x right, y up, z towards the viewer.

    key : direction towards the key light, not of unit length
    """

    key: Vector = (-0.50, 0.55, 0.75)
    key_colour: Vector = (2.05, 1.9065, 1.722)
    fill_colour: Vector = (0.186, 0.222, 0.30)
    sky: Vector = (0.238, 0.272, 0.34)
    ground: Vector = (0.124, 0.084, 0.068)
    rim_colour: Vector = (1.125, 1.29, 1.5)
    exposure: float = 0.78

    def constants(self) -> dict[str, str]:
        """Return the constants of the shaders: name -> GLSL."""
        colours = ("key_colour", "fill_colour", "sky", "ground", "rim_colour")
        constants = {name.upper(): _vec3(getattr(self, name)) for name in colours}
        return constants | {"KEY": f"normalize({_vec3(self.key)})", "EXPOSURE": f"{self.exposure:.4f}"}


def _vec3(vector: Vector) -> str:
    x, y, z = vector
    return f"vec3({x:.4f}, {y:.4f}, {z:.4f})"


STUDIO = Lighting()
LIGHTS = {  # key, key_colour, fill_colour; sky, ground, rim_colour
    "studio": STUDIO,
    "daylight": Lighting(
        (-0.25, 0.80, 0.70), (1.75, 1.80, 1.82), (0.34, 0.40, 0.48),
        (0.42, 0.50, 0.62), (0.20, 0.20, 0.16), (0.8, 0.9, 1.0),
    ),
    "evening": Lighting(
        (-0.80, 0.25, 0.60), (2.50, 1.55, 0.85), (0.10, 0.14, 0.26),
        (0.13, 0.15, 0.28), (0.12, 0.07, 0.05), (1.9, 1.1, 0.6),
    ),
    "from the right": Lighting(key=(0.70, 0.45, 0.60), fill_colour=(0.10, 0.12, 0.16)),
    "dramatic": Lighting(
        (-0.95, 0.50, 0.25), (2.6, 2.45, 2.3), (0.03, 0.04, 0.06),
        (0.07, 0.08, 0.11), (0.04, 0.03, 0.03),
    ),
    "even": Lighting(
        (0.0, 0.30, 1.0), (1.25, 1.22, 1.18), (0.55, 0.56, 0.58),
        (0.45, 0.46, 0.48), (0.30, 0.28, 0.26), (0.2, 0.2, 0.2),
    ),
}  # fmt: skip
