"""Characters without a human face, authored in code for the layers: a globe and a cassette radio."""

from mien.library.characters.globe import globe
from mien.library.characters.radio import radio

__all__ = ["globe", "radio"]
