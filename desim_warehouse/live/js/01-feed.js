// Calls of the server with the page's token, and the stream of answers.

const SILENT = 12000; // milliseconds without a word after which the server is gone

class Feed {
  constructor(token) {
    this.token = token;
  }

  async call(path, body, signal) {
    const headers = { Authorization: `Bearer ${this.token}`, ...(body ? { "Content-Type": "application/json" } : {}) };
    const options = { method: body ? "POST" : "GET", headers, signal, cache: "no-store", credentials: "omit" };
    const answer = await fetch(path, body ? { ...options, body: JSON.stringify(body) } : options);
    if (!answer.ok) {
      const { problems } = await answer.json().catch(() => ({}));
      throw new RefusedError(answer.status, problems ?? [`HTTP ${answer.status}`]);
    }
    return answer;
  }

  async ask(path, body) {
    return (await this.call(path, body)).json();
  }

  // Tell every answer on a design until the signal is given. It ends with an error where the server does not go on.
  async listen(path, signal, tell) {
    const silence = new AbortController(), either = new AbortController();
    for (const one of [signal, silence.signal]) one.addEventListener("abort", () => either.abort());
    let clock = setTimeout(() => silence.abort(), SILENT);
    try {
      const answer = await this.call(path, null, either.signal);
      const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
      for (let rest = ""; ; ) {
        const { done, value } = await reader.read();
        if (done) throw new Error("the stream has ended");
        clearTimeout(clock);
        clock = setTimeout(() => silence.abort(), SILENT);
        const events = (rest + value).split("\n\n");
        rest = events.pop();
        for (const event of events) if (!signal.aborted) this.read(event, tell);
      }
    } finally {
      clearTimeout(clock);
    }
  }

  read(event, tell) {
    const lines = Object.fromEntries(event.split("\n").map((line) => [line.slice(0, line.indexOf(":")), line.slice(line.indexOf(":") + 2)]));
    if (lines.event === "answer") tell(JSON.parse(lines.data));
  }
}
