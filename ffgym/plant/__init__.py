"""What happens: robots as MuJoCo simulates them."""

from ffgym.plant.climate import Climate as Climate
from ffgym.plant.draws import Distribution as Distribution
from ffgym.plant.draws import LogUniform as LogUniform
from ffgym.plant.draws import PlantDistribution as PlantDistribution
from ffgym.plant.draws import Uniform as Uniform
from ffgym.plant.draws import with_payload as with_payload
from ffgym.plant.machine import Machine as Machine
from ffgym.plant.machine_file import load_machine as load_machine
from ffgym.plant.machine_text import save_machine as save_machine
from ffgym.plant.plant import Plant as Plant
from ffgym.plant.plant_state import PlantState as PlantState
