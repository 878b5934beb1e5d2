// What the pages have in common: text into elements, the state of the link, and the lines that were told.

const SILENT_MS = 500;

// The same of a camera or of the hand, by the operator's clock; it says so of the arm itself.
const SILENT_US = 5e5;

// There and back: the console takes no press from a page that has heard of it longer ago (HEARD_US of control.rs).
const LATE_MS = 250;

export const find = (id) => document.getElementById(id);

// Changes an element's text where it differs, so that readers of the screen are not told it again.
export function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export function ms(us) {
  return us === null || us === undefined ? "never" : us < 1e6 ? `${(us / 1000).toFixed(0)} ms` : `${(us / 1e6).toFixed(1)} s`;
}

export const inWords = (milliseconds) => ms(milliseconds * 1000);

// Whether something of that age is known now; one without an age never came.
export const isHeard = (us) => us !== null && us !== undefined && us <= SILENT_US;

// What is known of the hand now. Of one that nothing was heard of for that long nothing is, however well it was known then.
export const knownBy = (hand) =>
  isHeard(hand.age_us) ? `${KNOWN[hand.state] ?? hand.state}, ${ms(hand.age_us)} ago` : `nothing: not heard for ${ms(hand.age_us)}`;

// Whether the arm is known to move by the button; what was heard of a slave that is silent says nothing of now.
export const isEngaged = (arm) => arm?.state === "engaged" && !arm.silent;

// What is said of an arm that is silent: the same for as long as it is, for readers of the screen.
const SILENT = "Its slave is silent: nobody knows what the arm does.";

export const standingOf = (arm) => (!arm ? "not heard yet" : arm.silent ? SILENT : arm.standing);

// The views to look at, each with its number: of the arm's cameras those that its slave has, as far as it has said.
export const viewsOf = (told, { pictures }) =>
  told.map((view, at) => ({ ...view, at })).filter(({ kind, at }) => kind !== "eye" || pictures.some(({ view }) => view === at));

// How the hand's pose is known.
const KNOWN = {
  both: "all balls in two cameras",
  three: "two cameras, not all balls",
  one: "one camera alone",
  predicted: "its past motion: not seen",
  held: "its last place: not seen",
  lost: "nothing: lost",
};

// What the operator is called where control is taken, as this browser keeps it.
const NAME = "tetrad-name";

export function keptName() {
  try {
    return localStorage.getItem(NAME) ?? "";
  } catch {
    // a browser may keep nothing
    return "";
  }
}

export function keepName(name) {
  try {
    localStorage.setItem(NAME, name.trim());
  } catch {
    // it counts as long as nobody asks for it
  }
}

// What takes letters, and what has keys of its own beside those.
const TEXT = "textarea, input:not([type=radio], [type=checkbox], [type=range], [type=file], [type=number])";
const CHOICE = "select, input[type=number]";

const isFor = (event, what) => Boolean(event.target.closest?.(what));

// Whether letters are text for what has the focus.
export const isWriting = (event) => isFor(event, TEXT);

// Whether keys are for what has the focus; elsewhere they are buttons.
export const isTyping = (event) => isFor(event, `${TEXT}, ${CHOICE}`);

// Rows of a table's body; each a list of texts.
export function rows(body, table) {
  while (body.rows.length > table.length) body.deleteRow(-1);
  table.forEach((texts, at) => {
    const row = body.rows[at] ?? body.insertRow();
    while (row.cells.length < texts.length) row.insertCell();
    texts.forEach((text, cell) => write(row.cells[cell], text));
  });
}

export function items(list, texts, name = "li") {
  while (list.children.length > texts.length) list.lastElementChild.remove();
  texts.forEach((text, at) => {
    const item = list.children[at] ?? list.appendChild(document.createElement(name));
    write(item, text);
  });
}

export function lines(list, told) {
  items(list, told.map((line) => line.text).reverse());
}

// Says whether the console is heard, and how old that is, now and ten times a second.
export function watchLink(live, element) {
  // numbers that change all the time are beside what readers of the screen are told
  const trip = document.createElement("span");
  trip.className = "trip";
  element.before(trip);
  const tell = () => {
    const silent = live.silentMs > SILENT_MS;
    const { age, tripMs } = live;
    const late = !silent && (tripMs > LATE_MS || (age !== null && age.ms + age.within > SILENT_MS));
    document.body.classList.toggle("silent", silent);
    document.body.classList.toggle("late", late);
    const known = Number.isFinite(live.silentMs);
    const since = known ? `for ${(live.silentMs / 1000).toFixed(1)} s` : "";
    const old = late && age !== null ? [`${inWords(age.ms)} old`] : [];
    const there = tripMs === null ? [] : [`${inWords(tripMs)} there and back`];
    write(trip, silent ? since : [...old, ...there].join(", "));
    const words = silent ? "NO CONNECTION" : late ? "LATE" : "connected";
    const more = [silent && live.why, ((silent && known) || late) && "what you see is old"].filter(Boolean);
    write(element, [words, more.join("; ")].filter(Boolean).join(": "));
  };
  setInterval(tell, 100);
  live.addEventListener("lost", tell);
}
