// What a field of the spec is, read from the service's own contract: a new follower, law or limit
// shows up in the page by itself.

export class Schemas {
  /** Of what is posted to a path, by the name of its schema. */
  constructor(openapi, path, name) {
    this.named = openapi.components.schemas;
    this.examples = openapi.paths[path].post.requestBody.content["application/json"].examples;
    this.spec = this.named[name];
  }

  resolved(schema) {
    const name = schema.$ref?.split("/").at(-1);
    const found = name ? { ...this.named[name], ...schema } : schema;
    return Array.isArray(found.type) ? { ...found, type: found.type.find((each) => each !== "null") } : found;
  }

  /** {shape, …}: const, union, dimension, range, choice, number, text, flag, group or raw. */
  described(given) {
    const schema = this.resolved(given);
    if ("const" in schema) return { shape: "const", value: schema.const };
    if (schema.discriminator) return { shape: "union", kinds: this.#kinds(schema) };
    const choices = this.#choices(schema);
    if (choices.length > 0) return this.#chosen(choices);
    if (schema.enum) return { shape: "choice", values: schema.enum };
    switch (schema.type) {
      case "number":
      case "integer":
        return { shape: "number", ...ends(schema) };
      case "string":
        return { shape: "text" };
      case "boolean":
        return { shape: "flag" };
      case "object":
        if (!schema.properties) return { shape: "raw" };
        return isRange(schema) ? { shape: "range" } : { shape: "group", schema };
      default:
        return { shape: "raw" };
    }
  }

  /** Members of anyOf, nested ones opened, without null. */
  #choices(schema) {
    if (!schema.anyOf) return [];
    return schema.anyOf
      .map((each) => this.resolved(each))
      .flatMap((each) => (each.anyOf ? this.#choices(each) : [each]))
      .filter((each) => each.type !== "null");
  }

  #chosen(choices) {
    const number = choices.find((each) => each.type === "number" || each.type === "integer");
    const range = choices.find(isRange);
    if (number && range) return { shape: "dimension", ...ends(number) };
    const union = choices.find((each) => each.discriminator);
    return this.described(union ?? choices[0]);
  }

  /** [[kind, schema]] of a union. */
  #kinds(schema) {
    const mapping = Object.entries(schema.discriminator.mapping);
    return mapping.map(([kind, $ref]) => [kind, this.resolved({ $ref })]);
  }
}

const isRange = ({ properties }) => Object.keys(properties ?? {}).sort().join() === "max,min";

function ends(schema) {
  return {
    least: schema.minimum ?? schema.exclusiveMinimum,
    most: schema.maximum ?? schema.exclusiveMaximum,
  };
}

/** A new member of a union: its kind, and what it cannot do without. */
export function newMember(schemas, kind, schema) {
  const made = { kind };
  for (const name of schema.required ?? []) {
    const found = schemas.described(schema.properties[name]);
    if (["number", "dimension"].includes(found.shape)) made[name] = START[name] ?? 10;
  }
  return made;
}

// Where a field that must be given starts from.
const START = { angle_deg: 60, arm_mm: 80, centre_distance_mm: 100, max_mm: 100 };
