// What a tab worked on, so that it goes on where it was when its page is loaded again.

const KEY = `quadfold ${location.pathname}`; // the address has the token: of this studio alone

/** Keep it, as far as the browser has room; undefined forgets it. */
export function remember(work) {
  try {
    if (work) sessionStorage.setItem(KEY, JSON.stringify(work));
    else sessionStorage.removeItem(KEY);
  } catch {
    sessionStorage.removeItem(KEY); // rather none than that of another job
  }
}

/** What was kept last, or undefined. */
export function remembered() {
  try {
    return JSON.parse(sessionStorage.getItem(KEY) ?? "null") ?? undefined;
  } catch {
    return undefined;
  }
}
