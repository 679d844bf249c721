// The page: sliders to problem to answer to pictures. Widgets and plots are Bokeh's.

const TOLERANCE = 1e-9; // of the certified bound, relative to the largest deflection
const RACE_TO = 1e-9, RACE_SWEEPS = 20000;
const FRAME_MILLISECONDS = 8; // of the race in each frame, so that the page stays quick
const PATIENCE_MILLISECONDS = 250; // of rest before a race begins
const RAMP_MILLISECONDS = 6000; // of the touchdown, from no load to the largest

/** @type {any} */
let ui = null;
/** @type {Map<string, Scene>} */
let scenes = new Map();
/** @type {{scene: Scene, problem: Problem, barrier: Barrier, answer: Answer, milliseconds: number}} */
let shown;
let waiting = false, settled = 0, playing = 0;
/** @type {{name: string, runner: Generator<Step>, points: Step[], milliseconds: number, over: boolean}[]} */
let runners = [];

/**
 * Begin; called once by the page, with Bokeh's models by name.
 * @param {Object<string, any>} models
 */
function start(models) {
  ui = models;
  const records = JSON.parse(document.getElementById("contactqp-scenes").textContent);
  scenes = new Map(records.map((/** @type {any} */ record) => [record.name, unpackScene(record)]));
  chooseScene();
}

/** Show another scene, as it is. */
function chooseScene() {
  const scene = scenes.get(ui.scene.value), { labels } = scene, names = [...scene.supports.keys()];
  ui.support.options = names;
  ui.support.value = names[0];
  setSlider(ui.load, scene.load);
  setSlider(ui.tension, scene.tension);
  setSlider(ui.lift, { value: 0, ...scene.lift, label: "lift of the support" });
  ui.relief.value = 1;
  const { rows } = scene.lattice;
  ui.row.setv({ start: 0, end: Math.max(1, rows - 1), value: Math.floor((rows - 1) / 2), visible: rows > 1 });
  for (const element of document.querySelectorAll("[data-plane], [data-line]")) {
    const { dataset } = /** @type {HTMLElement} */ (element);
    /** @type {HTMLElement} */ (element).hidden = ("line" in dataset) !== (rows === 1);
  }
  ui.map.below[0].axis_label = labels.x;
  ui.map.left[0].axis_label = labels.y;
  ui.section.left[0].axis_label = labels.height;
  ui.reactions.left[0].axis_label = labels.pressure;
  ui.reactions.below[0].axis_label = labels.x;
  changed();
}

/** @param {any} slider @param {Slide} slide */
function setSlider(slider, { value, least, most, label }) {
  slider.setv({ start: least, end: most, step: (most - least) / 400, value, title: label });
}

/** Something was moved: solve anew before the next frame. */
function changed() {
  if (waiting || ui === null || !scenes.size) return;
  waiting = true;
  requestAnimationFrame(() => {
    waiting = false;
    solveAndShow();
  });
}

function solveAndShow() {
  const scene = scenes.get(ui.scene.value);
  const settings = {
    support: ui.support.value, load: ui.load.value, tension: ui.tension.value, lift: ui.lift.value, relief: ui.relief.value,
  };
  const begun = performance.now();
  const problem = problemOf(scene, settings);
  const barrier = parabolaBarrier(problem.lattice);
  const answer = solveContact(problem, barrier, TOLERANCE);
  shown = { name: ui.scene.value, scene, settings, problem, barrier, answer, milliseconds: performance.now() - begun };
  show();
  runners = [];
  settled = performance.now();
  if (!playing) setTimeout(maybeRace, PATIENCE_MILLISECONDS);
}

function show() {
  const { scene, problem, answer } = shown, { rows, columns } = problem.lattice, { spacing, left, bottom } = scene;
  const Image = ui.map_source.data.state[0].constructor;
  /** @type {Object<string, any>} */
  const data = {
    x: [left - spacing / 2],
    y: [bottom - spacing / 2],
    width: [columns * spacing],
    height: [rows * spacing],
  };
  for (const [name, values] of Object.entries(mapOf(scene, problem, answer))) data[name] = [new Image(values, [rows, columns])];
  ui.map_source.data = data;
  for (const [mapper, name] of [[ui.gap_mapper, "gap"], [ui.pressure_mapper, "pressure"]]) {
    const most = data[name][0].reduce((/** @type {number} */ a, /** @type {number} */ b) => (b > a ? b : a), 0);
    mapper.setv({ low: 0, high: most || 1 });
  }
  showSection();
  const words = wordsOf(scene, problem, answer);
  words["multigrid-steps"] = String(answer.cycles);
  words["multigrid-work"] = told(answer.work);
  words["multigrid-bound"] = toldBound(answer.certificate.bound / answer.scale);
  words["multigrid-milliseconds"] = told(shown.milliseconds, 2);
  write(words);
  const { contact, clear, undecided } = answer.certificate;
  ui.map.html_attributes = {
    role: "img",
    "aria-label": `Map of the nodes: ${contact} in contact, ${clear} clear, ${undecided} undecided.`,
  };
}

/** @param {Object<string, string>} words */
function write(words) {
  for (const [name, text] of Object.entries(words)) {
    const element = document.getElementById(`contactqp-${name}`);
    if (element !== null && element.textContent !== text) element.textContent = text;
  }
}

/** Show the row that the slider names. */
function showSection() {
  if (!shown) return;
  const { scene, problem, answer } = shown;
  const row = Math.min(Math.round(ui.row.value), problem.lattice.rows - 1), y = scene.bottom + row * scene.spacing;
  ui.section_source.data = sectionOf(scene, problem, answer, row);
  ui.bars.glyph.width = 0.8 * scene.spacing;
  const [least, most] = heightsOf(scene, problem, answer);
  // Downwards is down on the picture, whichever way heights are counted.
  ui.section.y_range.setv(scene.sign > 0 ? { start: most, end: least } : { start: -most, end: -least });
  const right = scene.left + (problem.lattice.columns - 1) * scene.spacing;
  ui.section.x_range.setv({ start: scene.left - 1.5 * scene.spacing, end: right + 1.5 * scene.spacing });
  ui.line.location = y;
  write({ y: told(y) });
}

/** Lay the section where the map was clicked. @param {number} y */
function cutAt(y) {
  const { scene, problem } = shown, row = Math.round((y - scene.bottom) / scene.spacing);
  ui.row.value = Math.max(0, Math.min(problem.lattice.rows - 1, row));
}

/** Choose what the map shows. @param {number} index */
function chooseQuantity(index) {
  ui.images.forEach((/** @type {any} */ image, /** @type {number} */ k) => (image.visible = k === index));
  ui.bar.visible = index > 0;
  if (index > 0) ui.bar.color_mapper = [ui.gap_mapper, ui.pressure_mapper][index - 1];
  document.getElementById("contactqp-legend").hidden = index > 0;
}

// The touchdown: the load grows from nothing to the slider's end, again and again.

/** @param {boolean} wanted */
function play(wanted) {
  if (!wanted) {
    cancelAnimationFrame(playing);
    playing = 0;
    settled = performance.now();
    setTimeout(maybeRace, PATIENCE_MILLISECONDS);
    return;
  }
  const { load } = shown.scene, most = load.value < 0 ? load.least : load.most;
  let begun = performance.now() - RAMP_MILLISECONDS * Math.max(0, Math.min(1, ui.load.value / most || 0)) * 0.999;
  const tick = (/** @type {number} */ now) => {
    if (now - begun > RAMP_MILLISECONDS) begun = now;
    ui.load.value = most * Math.max(0, (now - begun) / RAMP_MILLISECONDS);
    playing = requestAnimationFrame(tick);
  };
  playing = requestAnimationFrame(tick);
}

// The race: both methods run on the problem that is shown, a few milliseconds in each frame.

function maybeRace() {
  if (playing || runners.length || performance.now() - settled < PATIENCE_MILLISECONDS - 1) return;
  race();
}

function race() {
  const { problem, barrier } = shown, beta = ui.beta.value;
  const methods = {
    multigrid: multigridSteps(problem, barrier, RACE_TO),
    relaxation: relaxationSteps(problem, barrier, RACE_TO, beta, RACE_SWEEPS),
  };
  runners = Object.entries(methods).map(([name, runner]) => ({ name, runner, points: [], milliseconds: 0, over: false }));
  const mine = runners;
  const tick = () => {
    if (runners !== mine) return;
    for (const runner of mine) advance(runner);
    if (mine.some((runner) => !runner.over)) requestAnimationFrame(tick);
  };
  tick();
}

/** The factor was moved: race anew. */
function restartRace() {
  runners = [];
  settled = performance.now();
  if (!playing) setTimeout(maybeRace, PATIENCE_MILLISECONDS);
}

/** @param {typeof runners[0]} runner */
function advance(runner) {
  if (runner.over) return;
  const begun = performance.now();
  while (!runner.over && performance.now() - begun < FRAME_MILLISECONDS / 2) {
    const { value, done } = runner.runner.next();
    if (done) runner.over = true;
    else runner.points.push(value);
  }
  runner.milliseconds += performance.now() - begun;
  const { name, points, milliseconds } = runner;
  ui[`${name}_source`].data = {
    work: points.map((point) => point.work),
    bound: points.map((point) => point.bound),
    steps: points.map((point) => point.steps),
  };
  widenRace();
  const last = points[points.length - 1];
  if (name === "relaxation" && last) {
    write({
      "relaxation-steps": String(last.steps),
      "relaxation-work": told(last.work),
      "relaxation-bound": toldBound(last.bound),
      "relaxation-milliseconds": told(milliseconds, 2),
    });
  }
}

/** Let the plot of the race hold all that was reached. */
function widenRace() {
  const points = runners.flatMap((runner) => runner.points);
  const bounds = points.map((point) => point.bound).filter((bound) => bound > 0 && bound < Infinity);
  if (!bounds.length) return;
  ui.race.x_range.end = 1.05 * Math.max(...points.map((point) => point.work));
  ui.race.y_range.setv({ start: Math.min(...bounds) / 2, end: 2 * Math.max(...bounds) });
}

/** What is shown, for programs that look at the page. */
function facts() {
  if (!shown) return null;
  const { contact, clear, undecided, bound } = shown.answer.certificate;
  const { scale, cycles } = shown.answer;
  // Of what is shown, not of the sliders, whose answer comes with the next frame.
  return {
    scene: shown.name, ...shown.settings, contact, clear, undecided, bound, scale, cycles,
    milliseconds: shown.milliseconds,
    raced: runners.length > 0 && runners.every((runner) => runner.over),
  };
}
