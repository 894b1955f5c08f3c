from .plan import SetpointPlan as SetpointPlan
from .plan import read_plan as read_plan
from .plan import write_plan as write_plan
