import subprocess
import sys


def test_importing_the_room_imports_neither_spacy_nor_torch():
    code = (
        "import sys, sloop_ppl.language\n"
        "assert not {'spacy', 'torch', 'rapidfuzz'} & set(sys.modules), sorted(sys.modules)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
