"""How well or badly a scan was made, in three named levels."""

from __future__ import annotations

from typing import Final

from .scanner import Scanner

FAULTS: Final[dict[str, Scanner]] = {
    "light": Scanner(
        range_noise_m=0.001,
        mixed_share=0.1,
        glass_return=0.05,
        glass_loss=0.2,
        dropout=0.002,
        registration_m=0.001,
        registration_deg=0.005,
    ),
    "medium": Scanner(
        range_noise_m=0.003,
        mixed_share=0.25,
        glass_return=0.1,
        dropout=0.01,
        dark_share=0.08,
        people=0.5,
        registration_m=0.004,
        registration_deg=0.03,
    ),
    "heavy": Scanner(
        range_noise_m=0.006,
        mixed_share=0.4,
        glass_return=0.15,
        glass_loss=0.4,
        grazing_from_deg=75.0,
        dropout=0.03,
        dark_share=0.15,
        dark_loss=0.75,
        people=1.5,
        registration_m=0.007,
        registration_deg=0.05,
    ),
}
"""Range noise from 1 to 6 mm; of poses, two standard deviations reach 15 mm and 0.1° where faults are heavy."""
