/* SPDX-License-Identifier: Apache-2.0 */
/* Style of a report's page: one column, quiet type, light and dark. */
#ifndef NP_REPORT_REPORT_STYLE_H
#define NP_REPORT_REPORT_STYLE_H

/* clang-format off */
static const char np_report_style[] =
    ":root{color-scheme:light dark;--ground:#fdfdfb;--ink:#1c1d20;--quiet:#62666e;--line:#dcdcd8;--band:#f3f3ef;"
    "--march:#3f7fd6;--approximation:#d4761c;--path:#2f9a5d;--grey:#8a8f98}\n"
    "@media(prefers-color-scheme:dark){:root{--ground:#15171a;--ink:#e6e6e2;--quiet:#9ba0a8;--line:#33373d;"
    "--band:#1d2024}}\n"
    "*{box-sizing:border-box}\n"
    "body{margin:0;background:var(--ground);color:var(--ink);"
    "font:17px/1.55 Charter,'Bitstream Charter','Source Serif 4',Georgia,'DejaVu Serif',serif}\n"
    "main{max-width:64rem;margin:0 auto;padding:3rem 1.5rem 5rem}\n"
    "h1{font-size:1.9rem;line-height:1.2;font-weight:600;margin:0 0 .3rem}\n"
    "h2{font-size:1.25rem;font-weight:600;margin:3.2rem 0 .6rem}\n"
    "h3{font-size:1rem;font-weight:600;margin:0}\n"
    "p{margin:.5rem 0;max-width:44rem}\n"
    "a{color:inherit}\n"
    "code{font:0.86em ui-monospace,'DejaVu Sans Mono',monospace}\n"
    ".quiet,figcaption{color:var(--quiet)}\n"
    ".notice{border-left:3px solid var(--approximation);padding:.1rem 1rem;margin:1.2rem 0}\n"
    ".lead{font-size:1.12rem;margin-top:1.4rem}\n"
    "figure{margin:1.2rem 0}\n"
    "figcaption{font-size:.9rem;line-height:1.45}\n"
    "table+figcaption,.scroll+figcaption{margin-top:.6rem}\n"
    ".scroll{overflow-x:auto}\n"
    ".plot svg{display:block;width:100%;height:auto}\n"
    ".front svg{min-width:40rem}\n"
    "table{border-collapse:collapse;font:14px/1.4 system-ui,'DejaVu Sans',sans-serif;"
    "font-variant-numeric:tabular-nums;min-width:100%}\n"
    "th,td{text-align:right;padding:.32rem .7rem;white-space:nowrap;border-bottom:1px solid var(--line)}\n"
    "th{font-weight:600;color:var(--quiet);vertical-align:bottom}\n"
    "th:first-child,td:first-child,.text{text-align:left}\n"
    "td.text{white-space:normal}\n"
    "td code{white-space:nowrap}\n"
    "tr.own td{font-weight:600}\n"
    "tr.front td:first-child::before{content:'\\25CF';color:var(--march);margin-right:.45em}\n"
    "tr.left td{color:var(--quiet)}\n"
    ".curves{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,24rem),1fr));gap:1.6rem 2rem}\n"
    ".curves figure{margin:0}\n"
    ".pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,25rem),1fr));gap:1.6rem 2rem}\n"
    ".pictures figure{margin:0}\n"
    ".pair{display:flex;gap:.5rem}\n"
    ".pair img{width:calc(50% - .25rem)}\n"
    "img{display:block;width:100%;height:auto;image-rendering:pixelated;margin-bottom:.4rem}\n"
    ".key{display:flex;flex-wrap:wrap;gap:.2rem 1.3rem;margin:.3rem 0 0;padding:0;list-style:none;"
    "font:13px/1.5 system-ui,'DejaVu Sans',sans-serif;color:var(--quiet)}\n"
    ".key i{display:inline-block;width:.75em;height:.75em;margin-right:.45em;border-radius:50%}\n"
    ".key .line{width:1.6em;height:0;border-radius:0;border-top:2px solid;vertical-align:.25em}\n"
    ".ramp{display:inline-block;width:7rem;height:.7em;margin:0 .5em;vertical-align:-.05em;"
    "background:linear-gradient(90deg,rgb(33,102,171),rgb(237,237,232),rgb(179,23,43))}\n";
/* clang-format on */

#endif
