"""What all requests and responses share.

Bodies are read strictly (`body`), errors become problem documents (`errors`, `problem`,
`violations`); middleware limits bodies, tags and cuts responses, logs and counts. Begin with
`problem.py`.
"""
