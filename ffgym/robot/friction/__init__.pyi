from .lugre import LuGreParameters as LuGreParameters
