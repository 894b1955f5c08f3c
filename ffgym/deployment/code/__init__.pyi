from .law import CodeCheck as CodeCheck
from .law import write_law_code as write_law_code
from .policy import PolicyCheck as PolicyCheck
from .policy import write_policy_onnx as write_policy_onnx
from .table import LawTable as LawTable
from .table import read_table as read_table
from .table import write_table as write_table
