"""What happens: robots as MuJoCo simulates them."""

from ffgym.plant.plant import Plant as Plant
from ffgym.plant.plant import PlantState as PlantState
