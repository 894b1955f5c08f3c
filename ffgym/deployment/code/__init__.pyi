from .law import CodeCheck as CodeCheck
from .law import write_law_code as write_law_code
from .policy import PolicyCheck as PolicyCheck
from .policy import write_policy_onnx as write_policy_onnx
