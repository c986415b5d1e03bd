#include <emmy/output/report_template.h>

namespace emmy
{
  // one page, no network; numbers are those of the ledger
  const char *const report_template = R"html(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>emmy</title>
<style>
@STYLE@
body { font: 15px/1.45 sans-serif; color: #1b1f24; max-width: 1180px; margin: 1.5em auto; padding: 0 1em; }
h1 { font-size: 1.6em; margin-bottom: 0.2em; }
h2 { font-size: 1.15em; border-bottom: 1px solid #c8ccd0; margin-top: 1.8em; }
pre { font-size: 12px; line-height: 1.35; overflow-x: auto; background: #f5f6f8; padding: 0.8em; }
code { background: #f5f6f8; padding: 0.15em 0.35em; }
table { border-collapse: collapse; font-size: 13px; }
td, th { padding: 0.15em 0.9em 0.15em 0; text-align: left; vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
.pair > div { min-width: 0; } .pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(500px, 100%), 1fr)); gap: 0.5em 2em; }
.curves { height: 260px; width: 100%; margin-bottom: 2.2em; }
.curves .dygraph-legend { background: rgba(255, 255, 255, 0.75); width: auto; left: auto !important; right: 8px; font-size: 12px; }
.bar { display: inline-block; height: 0.8em; background: #4a79b8; }
.muted { color: #5d6670; }
#last { columns: 3 300px; font-size: 13px; } #last div { display: flex; justify-content: space-between; }
#last b { font-weight: normal; font-variant-numeric: tabular-nums; }
#film canvas { width: 100%; box-sizing: border-box; border: 1px solid #d5d8dc; touch-action: none; }
#scale { height: 14px; width: 260px; display: inline-block; vertical-align: middle; margin: 0 0.5em; }
#files a { display: inline-block; margin-right: 1.2em; }
@media print { body { max-width: none; font-size: 11px; } .controls, select { display: none; }
  .pair > div, #film, table { break-inside: avoid; } pre { white-space: pre-wrap; } }
</style>
</head>
<body>
<h1 id="title"></h1>
<p class="muted" id="summary"></p>
<p>Repeat it: <code id="command"></code></p>
<section id="film" hidden>
<h2>Particles</h2>
<canvas></canvas>
<p><span id="label"></span>: <span id="low"></span><span id="scale"></span><span id="high"></span>
<span class="muted" id="extremes"></span></p>
<p class="controls"><button id="play">play</button> <input id="frame" type="range" min="0" value="0" style="width: 60%">
<span id="moment"></span> <span class="muted" id="hint"></span></p>
</section>
<section id="curves"><h2>Ledger</h2><p class="muted" id="note"></p><div class="pair"></div></section>
<section class="controls" id="any" hidden><h2>Any column</h2><p><select></select></p><div class="curves"></div></section>
<section><h2>At the end</h2><div id="last"></div></section>
<section><h2>Where the time went</h2><p id="seconds"></p><table id="phases"></table></section>
<section><h2>Scene</h2><pre id="card"></pre></section>
<section><h2>Files</h2><p id="files"></p></section>
<script>@LIBRARY@</script>
<script>const run = @DATA@;</script>
<script>
'use strict';
const find = selector => document.querySelector(selector);
const brief = x => Number.isFinite(x) ? String(Number(x.toPrecision(5))) : String(x);
const column = name => run.columns.indexOf(name);
const escape = text => text.replace(/[&<>"]/g, c => '&#' + c.charCodeAt(0) + ';');

document.title = run.title;
find('#title').textContent = run.title;
find('#summary').textContent = 'emmy ' + run.version + ', ' + run.ended + '. ' + run.steps + ' steps to t = ' +
  brief(run.rows[run.rows.length - 1][column('time')]) + ' s on ' + run.timing.ranks + (run.timing.ranks === 1 ? ' rank, ' : ' ranks, ') +
  brief(run.timing.total_seconds) + ' s, ' + brief(run.timing.peak_memory_bytes / 1e6) + ' MB.';
find('#command').textContent = run.command;
find('#card').textContent = run.card;
find('#files').innerHTML = run.files.map(file => '<a href="' + encodeURI(file) + '">' + escape(file) + '</a>').join(' ');

const last = run.rows[run.rows.length - 1];
find('#last').innerHTML = run.columns.map((name, c) => '<div>' + escape(name) + ' <b data-column="' + escape(name) +
  '">' + last[c] + '</b></div>').join('');

const phases = run.timing.phases.slice().sort((a, b) => b.seconds - a.seconds).filter(phase => phase.share_percent > 0.05);
find('#seconds').textContent = brief(run.timing.total_seconds) + ' s in all, ' + run.timing.newton_iterations +
  ' iterations of Newton, ' + run.timing.linear_iterations + ' of the linear solver.';
find('#phases').innerHTML = '<tr><th>phase</th><th>s</th><th>%</th><th></th></tr>' + phases.map(phase =>
  '<tr><td>' + escape(phase.name) + '</td><td class="number">' + brief(phase.seconds) + '</td><td class="number">' +
  phase.share_percent.toFixed(1) + '</td><td><span class="bar" style="width:' + 3 * phase.share_percent + 'px"></span></td></tr>').join('');

// curves ------------------------------------------------------------------
let drawn = 0;
function draw(element, title, names, unit, computed)
{
  const data = run.rows.map(row => [row[column('time')]].concat(names.map(name => row[column(name)]),
    computed ? [computed.of(row)] : []));
  ++drawn;
  return new Dygraph(element, data, { labels: ['t'].concat(names, computed ? [computed.name] : []), title: title,
    titleHeight: 20, xlabel: 't (s)', ylabel: unit, xLabelHeight: 14, yLabelWidth: 14, legend: 'always',
    strokeWidth: 1.5, connectSeparatedPoints: true,
    axes: { x: { valueFormatter: v => 't ' + brief(v) + ' s' }, y: { axisLabelWidth: 72, valueFormatter: v => brief(v),
      axisLabelFormatter: v => String(Number(v.toPrecision(3))) } } });
}

function drawAll()
{
  const groups = [
    ['Energies', ['kinetic_energy'].concat(run.stored), 'J', run.stored.length ? { name: 'total', of: row =>
      ['kinetic_energy'].concat(run.stored).reduce((sum, name) => sum + row[column(name)], 0) } : null],
    ['Balance error (sum)', ['balance_error'], 'J'],
    ['Linear momentum', run.columns.filter(name => name.startsWith('linear_momentum')), 'kg m/s'],
    ['Angular momentum', run.columns.filter(name => /^angular_momentum_[xyz]$/.test(name)), 'kg m²/s'],
    ['Works (sums)', run.work, 'J'],
    ['Losses by cause (sums)', run.dissipated, 'J'],
    ['Newton iterations', ['newton_iterations'], ''],
    ['Time step', ['time_step'], 's'],
  ].concat(run.measured.map(group => [group.name, group.columns, '']));
  for (const [title, names, unit, computed] of groups)
    if (names.length)
      {
        const frame = document.createElement('div'), element = document.createElement('div');
        element.className = 'curves';
        frame.append(element);
        find('#curves .pair').append(frame);
        draw(element, title, names, unit, computed);
      }
  find('#note').textContent = 'Drag to zoom, double click to see all.' + (run.thinned ?
    ' Every ' + run.thinned + 'th row is drawn; ledger.csv has all.' : '');
  find('#any').hidden = false;
  const select = find('#any select');
  const named = run.columns.filter(name => name !== 'step' && name !== 'time'), shown = groups.flatMap(group => group[1]);
  select.innerHTML = named.map(name => '<option>' + escape(name) + '</option>').join('');
  select.value = named.find(name => !shown.includes(name)) || named[0];
  const redraw = () => draw(find('#any .curves'), '', [select.value], '');
  select.onchange = redraw;
  redraw();
}

if (typeof Dygraph === 'undefined')
  find('#note').textContent = 'No curves: the library that draws them was not there when the page was written. ' +
    'Install the package libjs-dygraphs and run again.';
else
  drawAll();
document.body.dataset.curves = drawn;

// film --------------------------------------------------------------------
const colours = [[48, 18, 59], [70, 107, 227], [40, 187, 236], [49, 242, 153], [162, 252, 60], [237, 208, 58], [251, 128, 34],
  [210, 49, 5], [122, 4, 3]];
function colour(part)
{
  const place = Math.min(Math.max(part, 0), 1) * (colours.length - 1), i = Math.min(Math.floor(place), colours.length - 2),
    rest = place - i;
  return 'rgb(' + colours[i].map((c, k) => Math.round(c + rest * (colours[i + 1][k] - c))).join(',') + ')';
}

function showFilm(film)
{
  const dim = film.dim, canvas = find('#film canvas'), pen = canvas.getContext('2d');
  // the number that is drawn stays between 0 and 1
  function numbers(text, ranges)
  {
    const bytes = atob(text), n = bytes.length / 2, codes = new Float64Array(n);
    for (let i = 0; i < n; ++i)
      {
        const c = i % ranges.length, [low, high] = c < dim ? ranges[c] : [0, 1];
        codes[i] = low + (high - low) * (bytes.charCodeAt(2 * i) + 256 * bytes.charCodeAt(2 * i + 1)) / 65535;
      }
    return codes;
  }
  const frames = film.frames.map(frame => numbers(frame.data, film.ranges)),
    lines = film.frames.map(frame => numbers(frame.lines, film.line_ranges)), hasLines = lines.some(line => line.length);
  // all particles, and of surfaces what is near
  const low = film.ranges.slice(0, dim).map(r => r[0]), high = film.ranges.slice(0, dim).map(r => r[1]),
    near = 0.15 * Math.max(...low.map((x, d) => high[d] - x));
  if (hasLines)
    for (let d = 0; d < dim; ++d)
      {
        low[d] = Math.min(low[d], Math.max(low[d] - near, film.line_ranges[d][0]));
        high[d] = Math.max(high[d], Math.min(high[d] + near, film.line_ranges[d][1]));
      }
  const middle = low.map((x, d) => (x + high[d]) / 2), size = Math.hypot(...low.map((x, d) => high[d] - x)) || 1;
  // how far particles are from their nearest ones at the start: the median of some
  const spacing = (codes => {
    const found = [], step = (dim + 1) * Math.max(1, Math.floor(codes.length / (dim + 1) / 200));
    for (let i = 0; i < codes.length; i += step)
      {
        let nearest = Infinity;
        for (let j = 0; j < codes.length; j += dim + 1)
          if (j !== i)
            nearest = Math.min(nearest, Math.hypot(...low.map((x, d) => codes[i + d] - codes[j + d])));
        found.push(nearest);
      }
    found.sort((a, b) => a - b);
    return Math.min(found[Math.floor(found.length / 2)], size);
  })(frames[0]);
  let turn = -0.6, tilt = 0.45, now = 0, timer = null;
  function project(codes, i)
  {
    const x = codes[i] - middle[0], y = codes[i + 1] - middle[1];
    if (dim === 2)
      return [x, y, 0];
    const z = codes[i + 2] - middle[2], a = Math.cos(turn) * x - Math.sin(turn) * y, b = Math.sin(turn) * x + Math.cos(turn) * y;
    return [a, Math.cos(tilt) * z + Math.sin(tilt) * b, Math.cos(tilt) * b - Math.sin(tilt) * z];
  }
  function show()
  {
    const wide = dim === 2 ? high[0] - low[0] : size, tall = dim === 2 ? high[1] - low[1] : size;
    canvas.width = 2 * canvas.clientWidth;
    canvas.height = Math.round(Math.min(Math.max(canvas.width * (tall || 1) / (wide || 1) + 60, 240), 0.52 * canvas.width));
    const factor = Math.min((canvas.width - 60) / (wide || 1), (canvas.height - 60) / (tall || 1)), codes = frames[now],
      n = codes.length / (dim + 1);
    const points = [];
    for (let i = 0; i < codes.length; i += dim + 1)
      points.push([...project(codes, i), codes[i + dim]]);
    if (dim === 3)
      points.sort((a, b) => b[2] - a[2]);
    const side = Math.max(3, factor * spacing * (dim === 2 ? 0.95 : 0.8));
    pen.clearRect(0, 0, canvas.width, canvas.height);
    for (const point of points)
      {
        pen.fillStyle = colour(point[3]);
        pen.fillRect(canvas.width / 2 + factor * point[0] - side / 2, canvas.height / 2 - factor * point[1] - side / 2, side, side);
      }
    pen.strokeStyle = dim === 2 ? '#333' : 'rgba(60, 60, 60, 0.45)';
    pen.lineWidth = dim === 2 ? 3 : 1;
    pen.beginPath();
    for (let i = 0; i < lines[now].length; i += 2 * dim)
      for (const [end, draw] of [[i, 'moveTo'], [i + dim, 'lineTo']])
        {
          const point = project(lines[now], end);
          pen[draw](canvas.width / 2 + factor * point[0], canvas.height / 2 - factor * point[1]);
        }
    pen.stroke();
    document.body.dataset.lines = lines[now].length / (2 * dim);
    find('#moment').textContent = 't = ' + brief(film.frames[now].time) + ' s';
    find('#extremes').textContent = '(in this frame ' + film.frames[now].extremes.map(brief).join(' to ') + ')';
    find('#frame').value = now;
    document.body.dataset.first = [brief(codes[0]), brief(codes[1]), n].join(' ');
  }
  find('#film').hidden = false;
  find('#label').textContent = film.label;
  [find('#low').textContent, find('#high').textContent] = film.ranges[dim].map(brief);
  find('#scale').style.background = 'linear-gradient(to right, ' + colours.map(c => 'rgb(' + c + ')').join(',') + ')';
  find('#hint').textContent = dim === 3 ? 'Drag to turn.' : '';
  find('#frame').max = frames.length - 1;
  find('#frame').oninput = event => { now = Number(event.target.value); show(); };
  find('#play').onclick = () => {
    if (timer)
      {
        clearInterval(timer);
        timer = null;
      }
    else
      timer = setInterval(() => { now = (now + 1) % frames.length; show(); }, 100);
    find('#play').textContent = timer ? 'stop' : 'play';
  };
  if (dim === 3)
    canvas.onpointermove = event => {
      if (event.buttons)
        {
          turn += event.movementX * 0.01;
          tilt = Math.min(Math.max(tilt + event.movementY * 0.01, -1.57), 1.57);
          show();
        }
    };
  window.addEventListener('resize', show);
  now = frames.length - 1;
  show();
  document.body.dataset.frames = frames.length;
}
if (run.film && run.film.frames.length)
  showFilm(run.film);
document.body.dataset.ready = 'yes';
</script>
</body>
</html>
)html";
} // namespace emmy
