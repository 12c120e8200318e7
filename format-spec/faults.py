"""How reader.py and blocks.py refuse a file: with a code of SPEC.md section 12."""
class FlbError(Exception):
    def __init__(self, code, message):
        super().__init__(f"FLB-{code} {message}")
        self.code = code
def need(holds, code, message):
    if not holds:
        raise FlbError(code, message)
