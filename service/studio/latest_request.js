// One question at a time: while one is being answered only the newest of those that come is kept.

const SLOW = 1500; // an answer that takes longer is given up for a newer question [ms]

export class LatestRequest {
  /** `ask` answers the present question, and may be given up by its signal. */
  constructor(ask) {
    this.ask = ask;
  }

  /** Asks now, or as soon as the question before is answered or given up. */
  async send() {
    if (this.busy) {
      this.again = true;
      clearTimeout(this.giveUp);
      this.giveUp = setTimeout(() => this.abort.abort(), SLOW - (performance.now() - this.began));
      return;
    }
    this.busy = true;
    this.began = performance.now();
    this.abort = new AbortController();
    try {
      await this.ask(this.abort.signal);
    } catch (error) {
      if (error.name !== "AbortError") throw error;
    } finally {
      clearTimeout(this.giveUp);
      this.busy = false;
    }
    if (this.again) {
      this.again = false;
      this.send();
    }
  }
}
