"""The look of the page."""

__all__ = ["STYLE"]

STYLE = """
:root{--ink:#1c2430;--soft:#5b6675;--line:#e3e7ec;--back:#f5f6f8;--card:#fff;--blue:#2b6cb0;--green:#2f9e62;--red:#d23f3f;--amber:#c77d0a}
*{box-sizing:border-box}
body{margin:0;background:var(--back);color:var(--ink);font:14px/1.45 system-ui,-apple-system,"Segoe UI",Roboto,sans-serif}
main{max-width:1060px;margin:0 auto;padding:28px 20px 40px}
header,section{background:var(--card);border:1px solid var(--line);border-radius:8px;padding:16px 20px;margin:0 0 14px}
header{border-top:5px solid var(--soft)}
header.success{border-top-color:var(--green)}header.failure,header.error,header.fault{border-top-color:var(--red)}
header.interrupted,header.unfinished{border-top-color:var(--amber)}
h1{font-size:22px;margin:0;display:flex;align-items:center;gap:12px;flex-wrap:wrap}
h2{font-size:15px;margin:0 0 10px}
.badge{font-size:12px;font-weight:650;letter-spacing:.04em;color:#fff;background:var(--soft);border-radius:20px;padding:3px 11px}
.success .badge{background:var(--green)}.failure .badge,.error .badge,.fault .badge{background:var(--red)}
.interrupted .badge,.unfinished .badge{background:var(--amber)}
.reason{margin:8px 0 0;font-size:15px}
.facts{display:flex;flex-wrap:wrap;gap:6px 26px;margin:12px 0 0;padding:0;list-style:none;color:var(--soft)}
.facts b{color:var(--ink);font-weight:600}
.note{margin:-4px 0 10px;color:var(--soft);font-size:13px}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%}
th{font-weight:600;color:var(--soft);font-size:12px;text-align:left}
th,td{padding:5px 14px 5px 0;border-bottom:1px solid var(--line);vertical-align:top;overflow-wrap:anywhere}
tr:last-child td{border-bottom:0}
.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
.outputs td{font-size:16px}.outputs td:nth-child(2){font-weight:650}
code{font:12.5px ui-monospace,SFMono-Regular,Menlo,Consolas,monospace}
.grid{display:grid;grid-template-columns:repeat(auto-fill,minmax(330px,1fr));gap:14px 22px}
figure{margin:0;min-width:0}
figcaption{display:flex;gap:8px;align-items:baseline;font-size:13px;flex-wrap:wrap}
figcaption span{color:var(--soft)}figcaption em{margin-left:auto;font-style:normal;font-variant-numeric:tabular-nums}
figure img{width:100%;image-rendering:pixelated;border-radius:4px;display:block;margin-top:4px}
svg{width:100%;height:auto;display:block}
svg text{font-size:11px;fill:var(--ink)}svg .r,svg .c{fill:var(--soft);font-size:10.5px}
svg .r{text-anchor:end}svg .c{text-anchor:middle}
svg .g{stroke:var(--line);fill:none}svg .l{stroke:var(--blue);stroke-width:1.6;fill:none}
svg .d{fill:var(--blue)}svg .b{fill:var(--blue);opacity:.16}svg .z{fill:#f8f9fb}
.s-running{fill:#8ab6e3;background:#8ab6e3}
.s-success{fill:var(--green);background:var(--green)}
.s-failure{fill:var(--red);background:var(--red)}
.s-invalid{fill:#9aa4b1;background:#9aa4b1}
.legend{display:flex;gap:16px;flex-wrap:wrap}.legend i{
 display:inline-block;width:11px;height:11px;border-radius:2px;margin-right:5px;vertical-align:-1px}
details>summary{cursor:pointer;font-weight:600}
footer{color:var(--soft);font-size:12px;text-align:center}
@media print{body{background:#fff}header,section{break-inside:avoid}}
"""
